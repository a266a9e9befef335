// SPDX-License-Identifier: Apache-2.0
// Normal matrices of octaves, and what follows from them.
#include "fit/octave_evidence.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace dermap {
namespace {

constexpr int kVarianceIterations = 12;
constexpr double kLeastVariance = 1e-9;  // scaled units

// What an octave's details have left unanswered: less what the next coarser one has.
std::vector<PlaneF> DetailOfResidual(const std::vector<OctaveLevel>& levels, std::size_t l) {
  std::vector<PlaneF> detail = levels[l].residual;
  for (std::size_t b = 0; b < detail.size() && l + 1 < levels.size(); ++b) {
    const PlaneF coarser = Double(levels[l + 1].residual[b], levels[l].shape);
    for (std::size_t i = 0; i < detail[b].size(); ++i) detail[b].data()[i] -= coarser.data()[i];
  }
  return detail;
}

}  // namespace

std::vector<OctaveEvidence> CollectEvidence(const PatchProblem& problem, const FitState& state,
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
    std::vector<const PlaneF*> activity;
    for (const Parameter p : problem.space().free())
      activity.push_back(detail.ActivityOf(l, levels[l].shape, p));
    for (std::size_t i = 0; i < octave.pixels.size(); ++i) {
      maker.Fill(i, rows);
      PixelEvidence& pixel = octave.pixels[i];
      pixel.normal = EvidenceMatrix::Zero(count, count);
      pixel.asked = EvidenceVector::Zero(count);
      EvidenceVector estimate(count), row(count);
      for (int j = 0; j < count; ++j) estimate[j] = levels[l].detail[j].data()[i];
      for (std::size_t b = 0; b < rows.size(); ++b) {
        for (int j = 0; j < count; ++j) row[j] = rows[b].blurred[j];
        const double weight = levels[l].weight[b].data()[i] / noise;
        pixel.normal += weight * row * row.transpose();
        pixel.asked += weight * residual[b].data()[i] * row;
      }
      pixel.asked += pixel.normal * estimate;
      // Of the details over the root of their activity.
      for (int j = 0; j < count; ++j) {
        const double root = activity[j] ? std::sqrt(activity[j]->data()[i]) : 1.0;
        pixel.normal.row(j) *= root;
        pixel.normal.col(j) *= root;
        pixel.asked[j] *= root;
      }
    }
  }
  return octaves;
}

void TakeLikeliestVariance(OctaveEvidence& octave) {
  const int count = static_cast<int>(octave.variance.size());
  for (int iteration = 0; iteration < kVarianceIterations; ++iteration) {
    EvidenceVector squares = EvidenceVector::Zero(count), determined = EvidenceVector::Zero(count);
    for (const PixelEvidence& pixel : octave.pixels) {
      EvidenceMatrix precision = pixel.normal;
      for (int j = 0; j < count; ++j) precision(j, j) += 1.0 / octave.variance[j];
      const EvidenceMatrix covariance =
          Eigen::LLT<EvidenceMatrix>(precision).solve(EvidenceMatrix::Identity(count, count));
      const EvidenceVector detail = covariance * pixel.asked;
      squares += detail.cwiseAbs2();
      for (int j = 0; j < count; ++j) determined[j] += 1.0 - covariance(j, j) / octave.variance[j];
    }
    for (int j = 0; j < count; ++j)
      octave.variance[j] =
          std::max(squares[j] / (octave.share * std::max(determined[j], 1e-6)), kLeastVariance);
  }
}

void Forget(int unknown, std::vector<OctaveEvidence>& octaves) {
  for (OctaveEvidence& octave : octaves)
    for (PixelEvidence& pixel : octave.pixels) {
      pixel.normal.row(unknown).setZero();
      pixel.normal.col(unknown).setZero();
      pixel.asked[unknown] = 0.0;
    }
}

std::vector<int> FreeIndices(const ChoiceStatus& status) {
  std::vector<int> free;
  for (std::size_t j = 0; j < status.free.size(); ++j)
    if (status.free[j]) free.push_back(static_cast<int>(j));
  return free;
}

EvidenceMatrix PrecisionOf(const PixelEvidence& pixel, const EvidenceVector& variance,
                           const std::vector<int>& free) {
  const int count = static_cast<int>(free.size());
  EvidenceMatrix precision(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) precision(a, b) = pixel.normal(free[a], free[b]);
    precision(a, a) += 1.0 / variance[free[a]];
  }
  return precision;
}

double LogEvidence(const std::vector<OctaveEvidence>& octaves, const ChoiceStatus& status,
                   const FreeVector& average) {
  const std::vector<int> free = FreeIndices(status);
  const int count = static_cast<int>(free.size());
  double sum = 0.0;
  for (const OctaveEvidence& octave : octaves) {
    // An absent unknown differs from average skin in the mean alone.
    EvidenceVector offset = EvidenceVector::Zero(static_cast<int>(status.free.size()));
    if (&octave == &octaves.back())
      for (std::size_t j = 0; j < status.free.size(); ++j)
        if (status.absent[j]) offset[static_cast<int>(j)] = -average[j];
    for (const PixelEvidence& pixel : octave.pixels) {
      const EvidenceVector pulled = pixel.asked - pixel.normal * offset;
      sum += offset.dot(pixel.asked) - 0.5 * offset.dot(pixel.normal * offset);
      if (count == 0) continue;
      EvidenceVector asked(count);
      double log_prior = 0.0;
      for (int a = 0; a < count; ++a) {
        asked[a] = pulled[free[a]];
        log_prior += std::log(octave.variance[free[a]]);
      }
      const Eigen::LLT<EvidenceMatrix> factor(PrecisionOf(pixel, octave.variance, free));
      double log_det = log_prior;
      for (int a = 0; a < count; ++a) log_det += 2.0 * std::log(factor.matrixLLT()(a, a));
      sum += 0.5 * asked.dot(factor.solve(asked)) - 0.5 * octave.share * log_det;
    }
  }
  return sum;
}

}  // namespace dermap
