// SPDX-License-Identifier: Apache-2.0
// The integral by Gauss and Legendre over the lens's blur, which is the narrower of the two.
#include "calibrate/spread_table.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dermap {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kWidths = 5.0;  // of the blur; 6e-7 of a Gaussian lies beyond
constexpr double kStep_px = 0.1;
constexpr double kBlurStep = 0.02;  // relative, for the derivative
// Nodes and weights of the 12-point rule on (-1, 1), the positive half [Abramowitz and Stegun, table 25.4].
constexpr std::array<double, 6> kNodes{0.125233408511469, 0.367831498998180, 0.587317954286617,
                                       0.769902674194305, 0.904117256370475, 0.981560634246719};
constexpr std::array<double, 6> kWeights{0.249147045813403, 0.233492536538355, 0.203167426723066,
                                         0.160078328543346, 0.106939325995318, 0.047175336386512};

}  // namespace

double NormalIntegral(double z) {
  return 0.5 * std::erfc(-z / std::sqrt(2.0));
}

double NormalDensity(double z) {
  return std::exp(-0.5 * z * z) / std::sqrt(2.0 * kPi);
}

double BlurredLoss(double d, double spread, double blur) {
  // With y = d - blur z: int over z < d / blur.
  const double low = -kWidths;
  const double high = std::min(kWidths, d / blur);
  if (high <= low) return 0.0;
  const double middle = 0.5 * (low + high);
  const double half = 0.5 * (high - low);
  double sum = 0.0;
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    for (const double z : {middle - half * kNodes[i], middle + half * kNodes[i]}) {
      sum += kWeights[i] * NormalDensity(z) * NormalIntegral(-(d - blur * z) / spread);
    }
  }
  return half * sum;
}

SpreadTable::SpreadTable(double spread_px, double blur_px, double reach_px)
    : first_(-kWidths * blur_px), step_(kStep_px) {
  const auto count = static_cast<std::size_t>((reach_px + 4.0 - first_) / step_) + 2;
  for (std::size_t i = 0; i < count; ++i) {
    const double d = first_ + step_ * static_cast<double>(i);
    const double loss = BlurredLoss(d, spread_px, blur_px);
    const double wider = BlurredLoss(d, spread_px, blur_px * (1.0 + kBlurStep));
    loss_.push_back(loss);
    by_blur_.push_back((wider - loss) / (kBlurStep * blur_px));
  }
}

SpreadTable::Values SpreadTable::At(double d) const {
  const double place = (d - first_) / step_;
  if (!(place >= 1.0) || place >= static_cast<double>(loss_.size()) - 2.0) return {0.0, 0.0, 0.0};
  const auto i = static_cast<std::size_t>(place);
  const double f = place - static_cast<double>(i);
  // Slope from central differences, interpolated: the value's own piecewise slope would jump at every step.
  const double here = loss_[i + 1] - loss_[i - 1];
  const double next = loss_[i + 2] - loss_[i];
  return {(1 - f) * loss_[i] + f * loss_[i + 1], ((1 - f) * here + f * next) / (2.0 * step_),
          (1 - f) * by_blur_[i] + f * by_blur_[i + 1]};
}

}  // namespace dermap
