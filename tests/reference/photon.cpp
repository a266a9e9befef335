// SPDX-License-Identifier: Apache-2.0
// Free paths by mu_s, absorption along the path, Fresnel's faces by chance.
#include "tests/reference/photon.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dermap::reference {
namespace {

constexpr double kRouletteGain = 10.0;

// Unpolarised reflectance of a face, and the cosine beyond it.
double FaceReflectance(double n1, double n2, double cos1, double& cos2) {
  if (n1 == n2) {
    cos2 = cos1;
    return 0.0;
  }
  const double sin2 = n1 / n2 * std::sqrt(std::max(0.0, 1.0 - cos1 * cos1));
  if (sin2 >= 1.0) return 1.0;
  cos2 = std::sqrt(1.0 - sin2 * sin2);
  const double perpendicular = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
  const double parallel = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
  return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

double HenyeyGreensteinCosine(double g, Random& random) {
  const double u = random.Uniform();
  if (std::abs(g) < 1e-6) return 2.0 * u - 1.0;
  const double f = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
  return std::clamp((1.0 + g * g - f * f) / (2.0 * g), -1.0, 1.0);
}

}  // namespace

PhotonWalk::PhotonWalk(const MonteCarloScene& scene, double roulette_weight)
    : scene_(scene), roulette_weight_(roulette_weight) {
  double cosine = 1.0;
  specular_ = FaceReflectance(scene.stack.n_above, scene.stack.layers.front().n, 1.0, cosine);
  top_mm_.push_back(0.0);
  for (const Layer& layer : scene.stack.layers) top_mm_.push_back(top_mm_.back() + layer.thickness_mm);
}

int PhotonWalk::PixelIndex(double position_mm, int count) const {
  double p = std::floor(position_mm / scene_.pixel_size_mm);
  if (scene_.periodic) p -= std::floor(p / count) * count;
  return static_cast<int>(std::clamp(p, 0.0, count - 1.0));
}

bool PhotonWalk::UnderTape(const Photon& p) const {
  return scene_.black_tape && (p.x < 0.0 || p.y < 0.0 || p.x >= scene_.width * scene_.pixel_size_mm ||
                               p.y >= scene_.height * scene_.pixel_size_mm);
}

PhotonWalk::Photon PhotonWalk::Launch(Random& random) const {
  Photon photon{0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0 - specular_, 0, 0};
  const double size_x = scene_.width * scene_.pixel_size_mm, size_y = scene_.height * scene_.pixel_size_mm;
  const bool window = scene_.beam == Beam::kWindow;
  photon.x = window ? size_x * random.Uniform() : 0.5 * size_x;
  photon.y = window ? size_y * random.Uniform() : 0.5 * size_y;
  return photon;
}

// Walks from pixel to pixel; a border that is far away (replicated maps) costs nothing.
double PhotonWalk::AbsorptionAlong(const PlaneF& mu_a, const Photon& p, double length_mm) const {
  const double size = scene_.pixel_size_mm;
  double x = p.x, y = p.y, left = length_mm, sum = 0.0;
  while (left > 0.0) {
    const double px = std::floor(x / size), py = std::floor(y / size);
    const double to_x = p.ux > 0.0   ? ((px + 1.0) * size - x) / p.ux
                        : p.ux < 0.0 ? (px * size - x) / p.ux
                                     : kInfinite;
    const double to_y = p.uy > 0.0   ? ((py + 1.0) * size - y) / p.uy
                        : p.uy < 0.0 ? (py * size - y) / p.uy
                                     : kInfinite;
    // A hair's breadth beyond the border, so that the next step starts in the next pixel.
    const double step = std::min(left, std::min(to_x, to_y) + 1e-9 * size);
    const double middle = 0.5 * step;
    sum += step *
           mu_a(PixelIndex(x + middle * p.ux, mu_a.width()), PixelIndex(y + middle * p.uy, mu_a.height()));
    x += step * p.ux;
    y += step * p.uy;
    left -= step;
  }
  return sum;
}

void PhotonWalk::Move(Photon& photon, double length_mm) const {
  const bool mapped = !scene_.mu_a.empty() && !scene_.mu_a[photon.layer].empty();
  const double optical = mapped ? AbsorptionAlong(scene_.mu_a[photon.layer], photon, length_mm)
                                : length_mm * scene_.stack.layers[photon.layer].mu_a;
  photon.weight *= std::exp(-optical);
  photon.x += length_mm * photon.ux;
  photon.y += length_mm * photon.uy;
  photon.z += length_mm * photon.uz;
}

void PhotonWalk::Scatter(Photon& p, Random& random) const {
  const double cosine = HenyeyGreensteinCosine(scene_.stack.layers[p.layer].g, random);
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  const double azimuth = 2.0 * std::numbers::pi * random.Uniform();
  const double a = sine * std::cos(azimuth), b = sine * std::sin(azimuth);
  ++p.scatterings;
  if (std::abs(p.uz) > 0.99999) {
    p.ux = a;
    p.uy = b;
    p.uz = std::copysign(cosine, p.uz * cosine);
    return;
  }
  const double root = std::sqrt(1.0 - p.uz * p.uz);
  const double ux = a * (p.ux * p.uz) / root - b * p.uy / root + p.ux * cosine;
  const double uy = a * (p.uy * p.uz) / root + b * p.ux / root + p.uy * cosine;
  const double uz = -a * root + p.uz * cosine;
  const double norm = 1.0 / std::sqrt(ux * ux + uy * uy + uz * uz);
  p.ux = ux * norm;
  p.uy = uy * norm;
  p.uz = uz * norm;
}

bool PhotonWalk::MeetFace(Photon& p, Random& random) const {
  const std::vector<Layer>& layers = scene_.stack.layers;
  const bool down = p.uz > 0.0;
  const int face = down ? p.layer + 1 : p.layer;  // face i lies above layer i
  p.z = top_mm_[face];
  const int last = static_cast<int>(layers.size());
  const double n1 = layers[p.layer].n;
  const double n2 = down ? (face == last ? scene_.stack.n_below : layers[face].n)
                         : (face == 0 ? scene_.stack.n_above : layers[face - 1].n);
  if (!down && face == 0 && UnderTape(p)) {
    p.weight = 0.0;
    return true;
  }
  double cosine = 1.0;
  if (random.Uniform() < FaceReflectance(n1, n2, std::abs(p.uz), cosine)) {
    p.uz = -p.uz;
    return false;
  }
  if (face > 0) {
    const bool mapped = !scene_.absorber_below.empty() && !scene_.absorber_below[face - 1].empty();
    const double absorbance =
        mapped ? scene_.absorber_below[face - 1](PixelIndex(p.x, scene_.absorber_below[face - 1].width()),
                                                 PixelIndex(p.y, scene_.absorber_below[face - 1].height()))
               : layers[face - 1].absorber_below;
    p.weight *= std::exp(-absorbance);
  }
  if ((down && face == last) || (!down && face == 0)) return true;
  p.ux *= n1 / n2;
  p.uy *= n1 / n2;
  p.uz = std::copysign(cosine, p.uz);
  p.layer += down ? 1 : -1;
  return false;
}

std::optional<Exit> PhotonWalk::Run(Random& random) const {
  Photon p = Launch(random);
  double depth_left = random.Exponential();  // optical, until the next scattering
  while (true) {
    const Layer& layer = scene_.stack.layers[p.layer];
    const double to_face = p.uz > 0.0   ? (top_mm_[p.layer + 1] - p.z) / p.uz
                           : p.uz < 0.0 ? (top_mm_[p.layer] - p.z) / p.uz
                                        : kInfinite;
    const double to_scattering = layer.mu_s > 0.0 ? depth_left / layer.mu_s : kInfinite;
    if (to_scattering < to_face) {
      Move(p, to_scattering);
      Scatter(p, random);
      depth_left = random.Exponential();
    } else {
      Move(p, std::max(0.0, to_face));
      depth_left = std::max(0.0, depth_left - to_face * layer.mu_s);
      if (MeetFace(p, random)) return Exit{p.uz < 0.0, p.x, p.y, p.weight, p.scatterings};
    }
    if (p.weight < roulette_weight_) {
      if (p.weight <= 0.0 || random.Uniform() * kRouletteGain >= 1.0) return std::nullopt;
      p.weight *= kRouletteGain;
    }
  }
}

}  // namespace dermap::reference
