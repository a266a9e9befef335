// SPDX-License-Identifier: Apache-2.0
// Evidence of subsets of the unknowns, and backward elimination.
#include "fit/scene_choice.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fit/octave_solver.h"

namespace dermap {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kUnknownCount, kUnknownCount>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kUnknownCount, 1>;

// What the data say of one pixel of an octave.
struct PixelEvidence {
  Matrix normal;  // N
  Vector asked;   // b: the estimate is (N + 1/S)^-1 b
};

struct OctaveEvidence {
  std::vector<PixelEvidence> pixels;
  Vector variance;   // S
  double share = 1;  // of the pixels' dimensions that details span
};

constexpr double kEvidenceToGiveUp = 1.0;  // log: what is told must be as good as known
constexpr double kToldVariance = 0.1;      // of the prior's, of a patch's mean: below, the data tell it
constexpr int kVarianceIterations = 12;
constexpr double kLeastVariance = 1e-9;  // scaled units

// Where each unknown stands.
struct Status {
  std::vector<char> free, absent;  // by free parameter of the problem
  int free_count() const { return static_cast<int>(std::count(free.begin(), free.end(), 1)); }
};

// MacKay's fixed point, as Update (fit/detail_model.h) without its guess: sets of parameters are compared at
// the variances that make the data likeliest, or a parameter would be given up for what was guessed of it.
void TakeLikeliestVariance(OctaveEvidence& octave) {
  const int count = static_cast<int>(octave.variance.size());
  for (int iteration = 0; iteration < kVarianceIterations; ++iteration) {
    Vector squares = Vector::Zero(count), determined = Vector::Zero(count);
    for (const PixelEvidence& pixel : octave.pixels) {
      Matrix precision = pixel.normal;
      for (int j = 0; j < count; ++j) precision(j, j) += 1.0 / octave.variance[j];
      const Matrix covariance = Eigen::LLT<Matrix>(precision).solve(Matrix::Identity(count, count));
      const Vector detail = covariance * pixel.asked;
      squares += detail.cwiseAbs2();
      for (int j = 0; j < count; ++j) determined[j] += 1.0 - covariance(j, j) / octave.variance[j];
    }
    for (int j = 0; j < count; ++j)
      octave.variance[j] =
          std::max(squares[j] / (octave.share * std::max(determined[j], 1e-6)), kLeastVariance);
  }
}

// What an octave's details have left unanswered: less what the next coarser one has.
std::vector<PlaneF> DetailOfResidual(const std::vector<OctaveLevel>& levels, std::size_t l) {
  std::vector<PlaneF> detail = levels[l].residual;
  for (std::size_t b = 0; b < detail.size() && l + 1 < levels.size(); ++b) {
    const PlaneF coarser = Double(levels[l + 1].residual[b], levels[l].shape);
    for (std::size_t i = 0; i < detail[b].size(); ++i) detail[b].data()[i] -= coarser.data()[i];
  }
  return detail;
}

std::vector<OctaveEvidence> Collect(const PatchProblem& problem, const FitState& state,
                                    const DetailView& detail, const SkinPoint& fixed) {
  const std::vector<OctaveLevel> levels = LineariseInOctaves(problem, state);
  const int count = problem.space().count();
  std::vector<OctaveEvidence> octaves(levels.size());
  std::vector<OctaveRow> rows(problem.data().bands.size());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const bool top = l + 1 == levels.size();
    const double noise = levels[l].noise_inflation * detail.scatter[l];
    OctaveEvidence& octave = octaves[l];
    octave.share = top ? 1.0 : kDetailShare;
    octave.variance.resize(count);
    for (int j = 0; j < count; ++j) octave.variance[j] = detail.prior[l][j] / octave.share;
    octave.pixels.resize(levels[l].shape.size());
    const RowMaker maker(problem, levels[l], top ? nullptr : BlurOf(detail, l), fixed);
    const std::vector<PlaneF> residual = DetailOfResidual(levels, l);
    for (std::size_t i = 0; i < octave.pixels.size(); ++i) {
      maker.Fill(i, rows);
      PixelEvidence& pixel = octave.pixels[i];
      pixel.normal = Matrix::Zero(count, count);
      pixel.asked = Vector::Zero(count);
      Vector estimate(count), row(count);
      for (int j = 0; j < count; ++j) estimate[j] = levels[l].detail[j].data()[i];
      for (std::size_t b = 0; b < rows.size(); ++b) {
        for (int j = 0; j < count; ++j) row[j] = rows[b].blurred[j];
        const double weight = levels[l].weight[b].data()[i] / noise;
        pixel.normal += weight * row * row.transpose();
        pixel.asked += weight * residual[b].data()[i] * row;
      }
      pixel.asked += pixel.normal * estimate;
    }
  }
  return octaves;
}

std::vector<int> FreeIndices(const Status& status) {
  std::vector<int> free;
  for (std::size_t j = 0; j < status.free.size(); ++j)
    if (status.free[j]) free.push_back(static_cast<int>(j));
  return free;
}

// N + 1/S of what is free.
Matrix PrecisionOf(const PixelEvidence& pixel, const Vector& variance, const std::vector<int>& free) {
  const int count = static_cast<int>(free.size());
  Matrix precision(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) precision(a, b) = pixel.normal(free[a], free[b]);
    precision(a, a) += 1.0 / variance[free[a]];
  }
  return precision;
}

double LogEvidence(const std::vector<OctaveEvidence>& octaves, const Status& status,
                   const FreeVector& average) {
  const std::vector<int> free = FreeIndices(status);
  const int count = static_cast<int>(free.size());
  double sum = 0.0;
  for (const OctaveEvidence& octave : octaves) {
    // An absent unknown differs from average skin in the mean alone.
    Vector offset = Vector::Zero(static_cast<int>(status.free.size()));
    if (&octave == &octaves.back())
      for (std::size_t j = 0; j < status.free.size(); ++j)
        if (status.absent[j]) offset[static_cast<int>(j)] = -average[j];
    for (const PixelEvidence& pixel : octave.pixels) {
      const Vector pulled = pixel.asked - pixel.normal * offset;
      sum += offset.dot(pixel.asked) - 0.5 * offset.dot(pixel.normal * offset);
      if (count == 0) continue;
      Vector asked(count);
      double log_prior = 0.0;
      for (int a = 0; a < count; ++a) {
        asked[a] = pulled[free[a]];
        log_prior += std::log(octave.variance[free[a]]);
      }
      const Eigen::LLT<Matrix> factor(PrecisionOf(pixel, octave.variance, free));
      double log_det = log_prior;
      for (int a = 0; a < count; ++a) log_det += 2.0 * std::log(factor.matrixLLT()(a, a));
      sum += 0.5 * asked.dot(factor.solve(asked)) - 0.5 * octave.share * log_det;
    }
  }
  return sum;
}

// One unknown less.
struct Removal {
  Status status;
  double evidence = 0.0, margin = 0.0;  // the second: over what is asked for
  std::size_t index = 0;                // of the candidate
};

// What giving an unknown up must gain in evidence. Where evidence is even, a value that is wrong does more
// harm to the others than a free one does; of what the data do not tell even the patch's mean there is
// nothing to lose.
std::vector<double> AskedToGiveUp(const OctaveEvidence& mean, const Status& status) {
  const std::vector<int> free = FreeIndices(status);
  const int count = static_cast<int>(free.size());
  const Matrix covariance = Eigen::LLT<Matrix>(PrecisionOf(mean.pixels.front(), mean.variance, free))
                                .solve(Matrix::Identity(count, count));
  std::vector<double> asked(status.free.size(), 0.0);
  for (int a = 0; a < count; ++a)
    asked[free[a]] =
        covariance(a, a) < kToldVariance * mean.variance[free[a]] ? kEvidenceToGiveUp : -kEvidenceForOne;
  return asked;
}

// Before anything is seen, most skin has no tattoo: logarithm of the odds.
constexpr double kOddsOfTattoo = -4.6;

double LogOdds(const std::vector<OctaveEvidence>& octaves, const Status& status,
               const ParameterSpace& space) {
  double odds = LogEvidence(octaves, status, space.mean());
  for (int j = 0; j < space.count(); ++j)
    if (status.free[j] && space.parameter(j) == Parameter::kJunctionAbsorbance) odds += kOddsOfTattoo;
  return odds;
}

// Of ink at the junction, the last of the unknowns: at the variances that the fit has. At the likeliest ones
// a trace of it would stand for errors of the model, and a trace is no tattoo.
double EvidenceOfInk(const std::vector<OctaveEvidence>& octaves, const ParameterSpace& space) {
  Status status{std::vector<char>(space.count(), 1), std::vector<char>(space.count(), 0)};
  const double with = LogOdds(octaves, status, space);
  status.free.back() = 0;
  return with - LogOdds(octaves, status, space);
}

// As if the data did not answer to it.
void Forget(int unknown, std::vector<OctaveEvidence>& octaves) {
  for (OctaveEvidence& octave : octaves)
    for (PixelEvidence& pixel : octave.pixels) {
      pixel.normal.row(unknown).setZero();
      pixel.normal.col(unknown).setZero();
      pixel.asked[unknown] = 0.0;
    }
}

Candidate CandidateOf(const ParameterSpace& space, const Status& status, double log_evidence) {
  Candidate candidate;
  candidate.log_evidence = log_evidence;
  for (int j = 0; j < space.count(); ++j) {
    if (status.free[j]) candidate.free.push_back(space.parameter(j));
    if (status.absent[j]) candidate.absent.push_back(space.parameter(j));
  }
  return candidate;
}

// Melanin is what every skin has; the junction without a tattoo keeps its base value.
bool MayBeAbsent(Parameter p) {
  return p == Parameter::kC_he || p == Parameter::kC_bc || p == Parameter::kC_hd;
}

// The unknown that is missed least of those that are free; all that are tried are added to `seen`. Ink was
// weighed before, so it is tried only `with_ink`.
std::optional<Removal> LeastMissed(const std::vector<OctaveEvidence>& octaves, const Status& status,
                                   double evidence, const ParameterSpace& space, bool with_ink,
                                   std::vector<Candidate>& seen) {
  std::optional<Removal> best;
  const std::vector<double> asked = AskedToGiveUp(octaves.back(), status);
  for (int j = 0; j < space.count(); ++j) {
    const Parameter p = space.parameter(j);
    if (!status.free[j] || p == Parameter::kC_m) continue;
    if (p == Parameter::kJunctionAbsorbance && !with_ink) continue;
    double at_average = 0.0;
    for (int absent = 0; absent <= (MayBeAbsent(p) ? 1 : 0); ++absent) {
      Removal removal{status};
      removal.status.free[j] = 0;
      removal.status.absent[j] = static_cast<char>(absent);
      removal.evidence = LogOdds(octaves, removal.status, space);
      removal.margin = removal.evidence - evidence - (absent ? -kEvidenceForOne : asked[j]);
      removal.index = seen.size();
      seen.push_back(CandidateOf(space, removal.status, removal.evidence));
      if (!absent) at_average = removal.evidence;
      if (absent && removal.evidence < at_average) continue;  // average skin's is likelier than none
      if (!best || removal.margin > best->margin) best = removal;
    }
  }
  return best;
}

}  // namespace

std::vector<Parameter> AllUnknowns() {
  std::vector<Parameter> unknowns;
  for (int i = 0; i < kUnknownCount; ++i) unknowns.push_back(static_cast<Parameter>(i));
  return unknowns;
}

std::vector<Candidate> ChooseCandidates(const PatchProblem& problem, const FitState& state,
                                        const DetailView& detail, const SkinPoint& fixed, int most) {
  const ParameterSpace& space = problem.space();
  std::vector<OctaveEvidence> octaves = Collect(problem, state, detail, fixed);
  Status status{std::vector<char>(space.count(), 1), std::vector<char>(space.count(), 0)};
  std::vector<Candidate> seen;
  const double ink = space.HasJunction() ? EvidenceOfInk(octaves, space) : 0.0;
  const int junction = space.HasJunction() ? space.count() - 1 : -1;
  Status other = status;
  if (junction >= 0) (ink > kEvidenceForOne ? other : status).free[junction] = 0;
  if (junction >= 0 && !status.free[junction]) Forget(junction, octaves);
  for (std::size_t l = 0; l + 1 < octaves.size(); ++l) TakeLikeliestVariance(octaves[l]);
  double evidence = LogOdds(octaves, status, space);
  if (junction >= 0)
    seen.push_back(CandidateOf(space, other, evidence + (status.free[junction] ? -ink : ink)));
  std::size_t chosen = seen.size();
  seen.push_back(CandidateOf(space, status, evidence));
  while (status.free_count() > 1) {
    const std::optional<Removal> best =
        LeastMissed(octaves, status, evidence, space, status.free_count() > most, seen);
    if (!best || (status.free_count() <= most && best->margin < 0.0)) break;
    status = best->status;
    evidence = best->evidence;
    chosen = best->index;
  }
  std::swap(seen[0], seen[chosen]);
  std::stable_sort(seen.begin() + 1, seen.end(),
                   [](const Candidate& a, const Candidate& b) { return a.log_evidence > b.log_evidence; });
  const double top = std::max_element(seen.begin(), seen.end(), [](const Candidate& a, const Candidate& b) {
                       return a.log_evidence < b.log_evidence;
                     })->log_evidence;
  for (Candidate& candidate : seen) candidate.log_evidence -= top;
  return seen;
}

bool LacksBands(const std::vector<Candidate>& candidates, int band_count) {
  const Candidate& chosen = candidates.front();
  const auto all =
      std::max_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.free.size() < b.free.size(); });
  const auto given_up = static_cast<double>(all->free.size() - chosen.free.size());
  return band_count <= kUnknownCount || all->log_evidence - chosen.log_evidence > kEvidenceForOne * given_up;
}

std::string NamesOf(const std::vector<Parameter>& parameters) {
  std::string names;
  for (const Parameter p : parameters) names += (names.empty() ? "" : ", ") + std::string(InfoOf(p).name);
  return names;
}

}  // namespace dermap
