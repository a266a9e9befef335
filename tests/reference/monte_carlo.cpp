// SPDX-License-Identifier: Apache-2.0
// Batches of photons on threads, and the sums that estimates and their standard errors are made of.
#include "tests/reference/monte_carlo.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>
#include <thread>

#include "tests/reference/photon.h"

namespace dermap::reference {
namespace {

constexpr std::uint64_t kBatch = 8192;
// Batches are summed in a fixed number of groups, each in order, so that rounding does not depend on the
// threads.
constexpr int kGroups = 16;

struct Tally {
  double sum = 0.0, square = 0.0;
  void Add(double weight) {
    sum += weight;
    square += weight * weight;
  }
  void Add(const Tally& other) {
    sum += other.sum;
    square += other.square;
  }
  // Mean over `photons` of something that is `scale` times the weight.
  Estimate Mean(double photons, double scale = 1.0) const {
    const double mean = sum / photons;
    const double variance = std::max(0.0, square / photons - mean * mean) / std::max(1.0, photons - 1.0);
    return {mean * scale, std::sqrt(variance) * scale};
  }
};

struct Tallies {
  Tally reflectance, transmittance, ballistic, single;
  std::vector<Tally> ring_r, ring_t, pixel_r, pixel_t;

  explicit Tallies(const MonteCarloScene& scene)
      : ring_r(std::max<std::size_t>(scene.radial_edges_mm.size(), 1) - 1),
        ring_t(ring_r.size()),
        pixel_r(static_cast<std::size_t>(scene.width) * scene.height),
        pixel_t(pixel_r.size()) {}

  void Add(const Tallies& other) {
    reflectance.Add(other.reflectance);
    transmittance.Add(other.transmittance);
    ballistic.Add(other.ballistic);
    single.Add(other.single);
    const auto add_all = [](std::vector<Tally>& to, const std::vector<Tally>& from) {
      for (std::size_t i = 0; i < to.size(); ++i) to[i].Add(from[i]);
    };
    add_all(ring_r, other.ring_r);
    add_all(ring_t, other.ring_t);
    add_all(pixel_r, other.pixel_r);
    add_all(pixel_t, other.pixel_t);
  }

  void Record(const MonteCarloScene& scene, const Exit& exit) {
    (exit.above ? reflectance : transmittance).Add(exit.weight);
    if (exit.above && exit.scatterings == 1) single.Add(exit.weight);
    if (!exit.above && exit.scatterings == 0) ballistic.Add(exit.weight);
    RecordRing(scene, exit);
    if (scene.width > 0) RecordPixel(scene, exit);
  }

 private:
  void RecordRing(const MonteCarloScene& scene, const Exit& exit) {
    const std::vector<double>& edges = scene.radial_edges_mm;
    if (edges.size() < 2) return;
    const double r = std::hypot(exit.x_mm - 0.5 * scene.width * scene.pixel_size_mm,
                                exit.y_mm - 0.5 * scene.height * scene.pixel_size_mm);
    const auto above = std::upper_bound(edges.begin(), edges.end(), r);
    if (above == edges.begin() || above == edges.end()) return;
    (exit.above ? ring_r : ring_t)[above - edges.begin() - 1].Add(exit.weight);
  }

  void RecordPixel(const MonteCarloScene& scene, const Exit& exit) {
    double px = std::floor(exit.x_mm / scene.pixel_size_mm), py = std::floor(exit.y_mm / scene.pixel_size_mm);
    if (scene.periodic) {
      px -= std::floor(px / scene.width) * scene.width;
      py -= std::floor(py / scene.height) * scene.height;
    }
    if (px < 0.0 || py < 0.0 || px >= scene.width || py >= scene.height) return;
    const auto index = static_cast<std::size_t>(py) * scene.width + static_cast<std::size_t>(px);
    (exit.above ? pixel_r : pixel_t)[index].Add(exit.weight);
  }
};

std::vector<Estimate> RingDensities(const std::vector<Tally>& rings, const std::vector<double>& edges,
                                    double photons) {
  std::vector<Estimate> densities;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const double area_mm2 = std::numbers::pi * (edges[i + 1] * edges[i + 1] - edges[i] * edges[i]);
    densities.push_back(rings[i].Mean(photons, 1.0 / area_mm2));
  }
  return densities;
}

void FillImage(const std::vector<Tally>& pixels, const MonteCarloScene& scene, double photons,
               Plane<double>& value, Plane<double>& error) {
  value = error = Plane<double>(scene.width, scene.height);
  // Of a window every pixel gets the same share of the photons.
  const double scale = scene.beam == Beam::kWindow ? static_cast<double>(pixels.size()) : 1.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Estimate e = pixels[i].Mean(photons, scale);
    value.values()[i] = e.value;
    error.values()[i] = e.standard_error;
  }
}

Tallies RunGroup(const MonteCarloScene& scene, const PhotonWalk& walk, const MonteCarloOptions& options,
                 int group) {
  Tallies tallies(scene);
  const std::uint64_t batches = (options.photons + kBatch - 1) / kBatch;
  for (std::uint64_t batch = group; batch < batches; batch += kGroups) {
    Random random(options.seed, batch);
    const std::uint64_t count = std::min(kBatch, options.photons - batch * kBatch);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (const auto exit = walk.Run(random)) tallies.Record(scene, *exit);
    }
  }
  return tallies;
}

}  // namespace

MonteCarloResult RunMonteCarlo(const MonteCarloScene& scene, const MonteCarloOptions& options) {
  const PhotonWalk walk(scene, options.roulette_weight);
  std::vector<Tallies> groups(kGroups, Tallies(scene));
  std::atomic<int> next{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < std::max(1, options.threads); ++t) {
      threads.emplace_back([&] {
        for (int group = next++; group < kGroups; group = next++)
          groups[group] = RunGroup(scene, walk, options, group);
      });
    }
  }
  Tallies total(scene);
  for (const Tallies& group : groups) total.Add(group);

  const auto photons = static_cast<double>(options.photons);
  MonteCarloResult result;
  result.photons = options.photons;
  result.seed = options.seed;
  result.specular = walk.specular();
  result.reflectance = total.reflectance.Mean(photons);
  result.transmittance = total.transmittance.Mean(photons);
  result.ballistic = total.ballistic.Mean(photons);
  result.single_scattering = total.single.Mean(photons);
  result.radial_reflectance = RingDensities(total.ring_r, scene.radial_edges_mm, photons);
  result.radial_transmittance = RingDensities(total.ring_t, scene.radial_edges_mm, photons);
  FillImage(total.pixel_r, scene, photons, result.reflectance_image, result.reflectance_image_error);
  FillImage(total.pixel_t, scene, photons, result.transmittance_image, result.transmittance_image_error);
  return result;
}

}  // namespace dermap::reference
