// SPDX-License-Identifier: Apache-2.0
// A polynomial in six variables, eight pixels at a time.
#include "common/transport/filter_width.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "common/core/kernel.h"
#include "common/core/lanes.h"
#include "common/transport/domain.h"

namespace dermap {
namespace {

constexpr int kDegree = 4, kShareDegree = 2;
constexpr int kShares = 4;  // and what the junction lets through
constexpr int kVariables = 2 + kShares;
constexpr int kSkins = 2000;

// Monomials of the shares, 1 first, then of the logarithms: all with degrees that fit together.
struct Exponents {
  std::array<int, kVariables> of{};
};

std::vector<Exponents> Monomials() {
  std::vector<Exponents> list;
  for (int a = 0; a <= kShareDegree; ++a)
    for (int b = 0; a + b <= kShareDegree; ++b)
      for (int c = 0; a + b + c <= kShareDegree; ++c)
        for (int d = 0; a + b + c + d <= kShareDegree; ++d)
          for (int x = 0; a + b + c + d + x <= kDegree; ++x)
            for (int y = 0; a + b + c + d + x + y <= kDegree; ++y) list.push_back({{x, y, a, b, c, d}});
  return list;
}

const std::vector<Exponents>& TheMonomials() {
  static const std::vector<Exponents> monomials = Monomials();
  return monomials;
}

// ln x for x > 0, to 1e-6: exponent, and atanh's series of the mantissa about 1.
inline __attribute__((always_inline)) void Logarithm(const Lanes& x, Lanes& out) {
  typedef std::int32_t WholeLanes __attribute__((vector_size(sizeof(Lanes))));
  const WholeLanes bits = (WholeLanes)x;
  const WholeLanes exponent = (bits - 0x3f3504f3) >> 23;  // mantissa in sqrt(1/2) ... sqrt(2)
  const Lanes mantissa = (Lanes)(bits - (exponent << 23));
  const Lanes t = (mantissa - 1.0f) / (mantissa + 1.0f), t2 = t * t;
  Lanes series = t2 * 0.142857143f + 0.2f;
  series = series * t2 + 0.333333333f;
  series = series * t2 + 1.0f;
  out = __builtin_convertvector(exponent, Lanes) * 0.693147181f + 2.0f * t * series;
}

struct Scaling {
  float log_middle[2], log_scale[2], eumelanin, blood, carotene;
};

// Planes of a run of pixels: C_m, beta_m, C_he, C_bc, mu_a of both layers, A.
enum Input { kMelanin, kType, kBloodAbove, kCaroteneAbove, kEpidermis, kDermis, kJunction, kInputs };
struct Pixels {
  const float* in[kInputs];
};

inline __attribute__((always_inline)) void Bound(Lanes& value, float low, float high) {
  value = value < low ? Lanes{} + low : value;
  value = value > high ? Lanes{} + high : value;
}

// Beyond table 1 a polynomial soon is anything: held at its border.
inline __attribute__((always_inline)) void SetVariables(const Scaling& s, const Pixels& pixels, std::size_t i,
                                                        Lanes* v) {
  const Lanes epidermis = DERMAP_LOAD(pixels.in[kEpidermis] + i),
              dermis = DERMAP_LOAD(pixels.in[kDermis] + i);
  const Lanes A = DERMAP_LOAD(pixels.in[kJunction] + i), C_m = DERMAP_LOAD(pixels.in[kMelanin] + i);
  Logarithm(epidermis, v[0]);
  Logarithm(dermis, v[1]);
  const Lanes inverse = 1.0f / epidermis;
  v[0] = (v[0] - s.log_middle[0]) * s.log_scale[0];
  v[1] = (v[1] - s.log_middle[1]) * s.log_scale[1];
  v[2] = C_m * DERMAP_LOAD(pixels.in[kType] + i) * s.eumelanin * inverse;
  v[3] = DERMAP_LOAD(pixels.in[kBloodAbove] + i) * s.blood * inverse;
  v[4] = DERMAP_LOAD(pixels.in[kCaroteneAbove] + i) * s.carotene * inverse;
  v[5] = A * A;
  Bound(v[0], -1.05f, 1.05f);
  Bound(v[1], -1.05f, 1.05f);
  for (int k = 2; k < kVariables; ++k) Bound(v[k], 0.0f, 1.0f);
}

// Powers of the variables, and their derivatives.
struct Powers {
  Lanes of[kVariables][kDegree + 1];
};
struct Slopes {
  Lanes of[kVariables][kDegree + 1];
};

inline __attribute__((always_inline)) void SetPowers(const Lanes* v, Powers& powers) {
  for (int k = 0; k < kVariables; ++k) {
    powers.of[k][0] = Lanes{} + 1.0f;
    for (int e = 1; e <= (k < 2 ? kDegree : kShareDegree); ++e) powers.of[k][e] = powers.of[k][e - 1] * v[k];
  }
}

inline __attribute__((always_inline)) void SetSlopes(const Powers& powers, Slopes& slopes) {
  for (int k = 0; k < kVariables; ++k) {
    slopes.of[k][0] = Lanes{};
    for (int e = 1; e <= (k < 2 ? kDegree : kShareDegree); ++e)
      slopes.of[k][e] = static_cast<float>(e) * powers.of[k][e - 1];
  }
}

DERMAP_KERNEL
void MultiplyByRatio(const Pixels& pixels, const Scaling& scaling, const float* coefficients, std::size_t n,
                     float* reflectance) noexcept {
  for (std::size_t i = 0; i < n; i += kLanes) {
    Lanes v[kVariables];
    Powers powers;
    SetVariables(scaling, pixels, i, v);
    SetPowers(v, powers);
    Lanes sum{};
    const float* coefficient = coefficients;
    for (int a = 0; a <= kShareDegree; ++a) {
      for (int b = 0; a + b <= kShareDegree; ++b) {
        for (int c = 0; a + b + c <= kShareDegree; ++c) {
          for (int d = 0; a + b + c + d <= kShareDegree; ++d) {
            const int left = kDegree - a - b - c - d;
            Lanes inner{};
            for (int x = 0; x <= left; ++x) {
              Lanes line{};
              for (int y = 0; x + y <= left; ++y) line += *coefficient++ * powers.of[1][y];
              inner += line * powers.of[0][x];
            }
            sum += powers.of[2][a] * powers.of[3][b] * powers.of[4][c] * powers.of[5][d] * inner;
          }
        }
      }
    }
    DERMAP_STORE(reflectance + i, DERMAP_LOAD(reflectance + i) * sum);
  }
}

// ratio, and its derivatives by the variables: slopes[variable].
DERMAP_KERNEL
void RatioAndSlopes(const Pixels& pixels, const Scaling& scaling, const float* coefficients, std::size_t n,
                    float* ratio, float* const* slopes) noexcept {
  for (std::size_t i = 0; i < n; i += kLanes) {
    Lanes v[kVariables], slope[kVariables] = {};
    Powers powers;
    Slopes of_powers;
    SetVariables(scaling, pixels, i, v);
    SetPowers(v, powers);
    SetSlopes(powers, of_powers);
    Lanes sum{};
    const float* coefficient = coefficients;
    for (int a = 0; a <= kShareDegree; ++a) {
      for (int b = 0; a + b <= kShareDegree; ++b) {
        for (int c = 0; a + b + c <= kShareDegree; ++c) {
          for (int d = 0; a + b + c + d <= kShareDegree; ++d) {
            const int left = kDegree - a - b - c - d;
            Lanes inner{}, inner_x{}, inner_y{};
            for (int x = 0; x <= left; ++x) {
              Lanes line{}, line_y{};
              for (int y = 0; x + y <= left; ++y, ++coefficient) {
                line += *coefficient * powers.of[1][y];
                line_y += *coefficient * of_powers.of[1][y];
              }
              inner += line * powers.of[0][x];
              inner_x += line * of_powers.of[0][x];
              inner_y += line_y * powers.of[0][x];
            }
            const Lanes A = powers.of[2][a], B = powers.of[3][b], C = powers.of[4][c], D = powers.of[5][d];
            const Lanes AB = A * B, CD = C * D;
            sum += AB * CD * inner;
            slope[0] += AB * CD * inner_x;
            slope[1] += AB * CD * inner_y;
            slope[2] += of_powers.of[2][a] * B * CD * inner;
            slope[3] += A * of_powers.of[3][b] * CD * inner;
            slope[4] += AB * of_powers.of[4][c] * D * inner;
            slope[5] += AB * C * of_powers.of[5][d] * inner;
          }
        }
      }
    }
    DERMAP_STORE(ratio + i, sum);
    for (int k = 0; k < kVariables; ++k) DERMAP_STORE(slopes[k] + i, slope[k]);
  }
}

}  // namespace

FilterWidth::FilterWidth(const BandOptics& band) {
  if (band.nodes.size() > 1 || !band.nodes[band.center].tables.correction.IsOne()) Fit(band);
}

void FilterWidth::Fit(const BandOptics& band) {
  center_ = band.nodes[band.center].absorbers;
  for (const BandOptics::Node& node : band.nodes) {
    eumelanin_ += static_cast<float>(node.weight * node.absorbers.eumelanin);
    blood_ += static_cast<float>(node.weight * node.absorbers.blood_epidermis);
    carotene_ += static_cast<float>(node.weight * node.absorbers.carotene);
  }
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  Eigen::MatrixXd variables(kSkins, kVariables);
  Eigen::VectorXd ratio(kSkins);
  for (int i = 0; i < kSkins; ++i) {
    ParameterVector p;
    for (int k = 0; k < kParameterCount; ++k) {  // denser where contents are small: there most skin is
      const double share = k == static_cast<int>(Parameter::kBeta_m) ? uniform() : std::pow(uniform(), 2);
      p[k] = kParameters[k].lower + (kParameters[k].upper - kParameters[k].lower) * share;
    }
    const double passes = 1.0 - 0.9 * std::pow(uniform(), 2);  // of the junction
    const auto corrected = [&](const BandOptics::Node& node) {
      return node.tables
          .CorrectedDerivatives(node.absorbers.MuAEpidermis(p), node.absorbers.MuADermis(p),
                                -std::log(passes))
          .reflectance;
    };
    double mean = 0.0;
    for (const BandOptics::Node& node : band.nodes) mean += node.weight * corrected(node);
    const BandOptics::Node& center = band.nodes[band.center];
    ratio[i] = mean / center.tables.TotalReflectance(center_.MuAEpidermis(p), center_.MuADermis(p),
                                                     -std::log(passes));
    const double epidermis = center_.MuAEpidermis(p);
    variables.row(i) << std::log(epidermis), std::log(center_.MuADermis(p)),
        p[0] * p[1] * eumelanin_ / epidermis, p[2] * blood_ / epidermis, p[3] * carotene_ / epidermis,
        passes * passes;
  }
  for (int layer = 0; layer < 2; ++layer) {
    const double low = variables.col(layer).minCoeff(), high = variables.col(layer).maxCoeff();
    log_middle_[layer] = static_cast<float>(0.5 * (low + high));
    log_scale_[layer] = static_cast<float>(2.0 / std::max(high - low, 1e-3));
    variables.col(layer) = (variables.col(layer).array() - log_middle_[layer]) * log_scale_[layer];
  }
  const std::vector<Exponents>& monomials = TheMonomials();
  Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(kSkins, static_cast<Eigen::Index>(monomials.size()));
  for (std::size_t m = 0; m < monomials.size(); ++m)
    for (int k = 0; k < kVariables; ++k)
      for (int e = 0; e < monomials[m].of[k]; ++e)
        basis.col(static_cast<Eigen::Index>(m)).array() *= variables.col(k).array();
  Eigen::MatrixXd normal = basis.transpose() * basis;
  normal.diagonal().array() += 1e-7 * kSkins;  // keeps what the shares hardly tell apart from growing
  const Eigen::VectorXd solution = normal.ldlt().solve(basis.transpose() * ratio);
  coefficients_.assign(solution.begin(), solution.end());
  error_ = std::sqrt((basis * solution - ratio).squaredNorm() / kSkins);
}

namespace {

// Calls body(pixels, first, count) for runs of whole lanes: the planes themselves, and what is left of them
// in a short copy.
template <class Body>
void ForRuns(const FilterWidth::Skin& skin, Body body) {
  const PlaneF* planes[kInputs] = {&skin.maps[Parameter::kC_m],  &skin.maps[Parameter::kBeta_m],
                                   &skin.maps[Parameter::kC_he], &skin.maps[Parameter::kC_bc],
                                   &skin.mu_a_epidermis,         &skin.mu_a_dermis,
                                   &skin.transmittance};
  const std::size_t size = skin.mu_a_epidermis.size(), whole = size / kLanes * kLanes;
  Pixels pixels{};
  for (int k = 0; k < kInputs; ++k) pixels.in[k] = planes[k]->data();
  if (whole > 0) body(pixels, std::size_t{0}, whole);
  if (whole == size) return;
  float last[kInputs][kLanes];
  for (int k = 0; k < kInputs; ++k) {
    std::fill_n(last[k], kLanes, planes[k]->data()[size - 1]);
    std::copy(planes[k]->data() + whole, planes[k]->data() + size, last[k]);
    pixels.in[k] = last[k];
  }
  body(pixels, whole, size - whole);
}

}  // namespace

void FilterWidth::Multiply(const Skin& skin, PlaneF& reflectance) const {
  if (empty()) return;
  const Scaling scaling{
      {log_middle_[0], log_middle_[1]}, {log_scale_[0], log_scale_[1]}, eumelanin_, blood_, carotene_};
  ForRuns(skin, [&](const Pixels& pixels, std::size_t first, std::size_t count) {
    float* to = reflectance.data() + first;
    if (count >= kLanes) return MultiplyByRatio(pixels, scaling, coefficients_.data(), count, to);
    float rest[kLanes] = {};
    std::copy_n(to, count, rest);
    MultiplyByRatio(pixels, scaling, coefficients_.data(), kLanes, rest);
    std::copy_n(rest, count, to);
  });
}

void FilterWidth::Derivatives(const Skin& skin, PlaneF& ratio,
                              std::array<PlaneF, kParameterCount + 1>& gradient) const {
  const PlaneF& C_m = skin.maps[Parameter::kC_m];
  EnsureShape(ratio, C_m.width(), C_m.height());
  for (PlaneF& plane : gradient) EnsureShape(plane, C_m.width(), C_m.height());
  if (empty()) {
    std::fill(ratio.values().begin(), ratio.values().end(), 1.0f);
    for (PlaneF& plane : gradient) std::fill(plane.values().begin(), plane.values().end(), 0.0f);
    return;
  }
  const Scaling scaling{
      {log_middle_[0], log_middle_[1]}, {log_scale_[0], log_scale_[1]}, eumelanin_, blood_, carotene_};
  ForRuns(skin, [&](const Pixels& pixels, std::size_t first, std::size_t count) {
    float rest[kVariables + 1][kLanes];
    const bool whole = count >= kLanes;
    float* to[kVariables];
    for (int k = 0; k < kVariables; ++k) to[k] = whole ? gradient[k].data() + first : rest[k];
    RatioAndSlopes(pixels, scaling, coefficients_.data(), whole ? count : kLanes,
                   whole ? ratio.data() + first : rest[kVariables], to);
    if (whole) return;
    for (int k = 0; k < kVariables; ++k) std::copy_n(rest[k], count, gradient[k].data() + first);
    std::copy_n(rest[kVariables], count, ratio.data() + first);
  });
  ToParameters(skin, gradient);
}

// From slopes by the variables to derivatives by parameters and by A, in place.
void FilterWidth::ToParameters(const Skin& skin, std::array<PlaneF, kParameterCount + 1>& gradient) const {
  const auto* C_m = skin.maps[Parameter::kC_m].data();
  const auto* beta = skin.maps[Parameter::kBeta_m].data();
  const auto* C_he = skin.maps[Parameter::kC_he].data();
  const auto* C_bc = skin.maps[Parameter::kC_bc].data();
  const auto base = static_cast<float>(center_.baseline);
  const auto pheo = static_cast<float>(center_.pheomelanin), eu = static_cast<float>(center_.eumelanin);
  const auto blood = static_cast<float>(center_.blood_epidermis) - base;
  const auto carotene = static_cast<float>(center_.carotene) - base;
  const auto below = static_cast<float>(center_.blood_dermis) - base;
  for (std::size_t i = 0; i < gradient[0].size(); ++i) {
    const float inverse = 1.0f / skin.mu_a_epidermis.data()[i], A = skin.transmittance.data()[i];
    const float x = gradient[0].data()[i] * log_scale_[0], y = gradient[1].data()[i] * log_scale_[1];
    const float of_eumelanin = gradient[2].data()[i] * eumelanin_, of_blood = gradient[3].data()[i] * blood_;
    const float of_carotene = gradient[4].data()[i] * carotene_, of_square = gradient[5].data()[i];
    // What a change of the epidermis's mu_a does: to its logarithm, and to all shares.
    const float by_mu_a =
        (x - (of_eumelanin * C_m[i] * beta[i] + of_blood * C_he[i] + of_carotene * C_bc[i]) * inverse) *
        inverse;
    gradient[0].data()[i] =
        by_mu_a * (beta[i] * (eu - pheo) + pheo - base) + of_eumelanin * beta[i] * inverse;
    gradient[1].data()[i] = by_mu_a * C_m[i] * (eu - pheo) + of_eumelanin * C_m[i] * inverse;
    gradient[2].data()[i] = by_mu_a * blood + of_blood * inverse;
    gradient[3].data()[i] = by_mu_a * carotene + of_carotene * inverse;
    gradient[4].data()[i] = y * below / skin.mu_a_dermis.data()[i];
    gradient[5].data()[i] = 2.0f * A * of_square;
  }
}

}  // namespace dermap
