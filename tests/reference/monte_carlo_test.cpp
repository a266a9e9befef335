// SPDX-License-Identifier: Apache-2.0
// The Monte Carlo against published values, the noise-free judge, and itself (seeds, images, rings).
#include "tests/reference/monte_carlo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/reference/adding_doubling.h"

namespace dermap::reference {
namespace {

MonteCarloResult Simulate(const LayerStack& stack, std::uint64_t photons, std::uint64_t seed = 1) {
  MonteCarloScene scene;
  scene.stack = stack;
  return RunMonteCarlo(scene, {.photons = photons, .seed = seed});
}

// van de Hulst 1980, table 35, as quoted by Wang, Jacques, Zheng 1995, table 1.
TEST(SlabMonteCarlo, MatchesVanDeHulst) {
  const auto r =
      Simulate({1.0, {{.thickness_mm = 1.0, .mu_a = 0.2, .mu_s = 1.8, .g = 0.75, .n = 1.0}}, 1.0}, 400000);
  EXPECT_NEAR(r.reflectance.value, 0.09739, 3 * r.reflectance.standard_error);
  EXPECT_NEAR(r.transmittance.value, 0.66096, 3 * r.transmittance.standard_error);
  EXPECT_NEAR(r.ballistic.value, std::exp(-2.0), 3 * r.ballistic.standard_error);
  EXPECT_LT(r.reflectance.standard_error, 5e-4);
}

// Giovanelli 1955, as quoted by Wang, Jacques, Zheng 1995.
TEST(HalfSpaceMonteCarlo, MatchesGiovanelli) {
  const auto r = Simulate({1.0, {{.mu_a = 0.1, .mu_s = 0.9, .n = 1.5}}, 1.5}, 150000);
  EXPECT_NEAR(r.reflectance.value + r.specular, 0.2600, 3 * r.reflectance.standard_error + 5e-5);
}

// Without absorption every photon leaves; source: conservation of energy.
TEST(LayersMonteCarlo, ConserveEnergy) {
  const auto r = Simulate({1.0,
                           {{.thickness_mm = 0.25, .mu_s = 6.0, .n = 1.4},
                            {.thickness_mm = 0.5, .mu_s = 15.0, .g = 0.8, .n = 1.38}},
                           1.33},
                          20000);
  EXPECT_NEAR(r.reflectance.value + r.transmittance.value + r.specular, 1.0, 1e-12);
}

struct Skin {
  double mu_a_epidermis, mu_a_dermis, absorbance;
};
class TwoLayerJudges : public ::testing::TestWithParam<Skin> {};

// Each judge is the other's source: adding-doubling shares no method with Monte Carlo.
TEST_P(TwoLayerJudges, Agree) {
  const auto [epidermis, dermis, absorbance] = GetParam();
  const LayerStack skin{
      1.0,
      {{.thickness_mm = 0.25, .mu_a = epidermis, .mu_s = 6.0, .n = 1.4, .absorber_below = absorbance},
       {.mu_a = dermis, .mu_s = 3.0, .n = 1.38}},
      1.38};
  const auto r = Simulate(skin, 150000, 7);
  EXPECT_NEAR(r.reflectance.value, NormalIncidenceTotals(skin).reflectance, 3 * r.reflectance.standard_error);
}
INSTANTIATE_TEST_SUITE_P(Skins, TwoLayerJudges,
                         ::testing::Values(Skin{0.5, 0.3, 0.0}, Skin{0.5, 0.3, 1.2}, Skin{8.0, 1.0, 0.0175},
                                           Skin{0.05, 5.0, 0.0}));

// Thin parts, through and back; source: adding-doubling.
TEST(ThreeLayerJudges, AgreeOnReflectanceAndTransmittance) {
  const Layer epidermis{.thickness_mm = 0.25, .mu_a = 0.3, .mu_s = 6.0, .n = 1.4, .absorber_below = 0.0175};
  const LayerStack ear{
      1.0,
      {epidermis,
       {.thickness_mm = 1.0, .mu_a = 0.1, .mu_s = 15.0, .g = 0.8, .n = 1.38, .absorber_below = 0.0175},
       epidermis},
      1.0};
  const auto r = Simulate(ear, 200000, 11);
  const Totals totals = NormalIncidenceTotals(ear);
  EXPECT_NEAR(r.reflectance.value, totals.reflectance, 3 * r.reflectance.standard_error);
  EXPECT_NEAR(r.transmittance.value, totals.transmittance, 3 * r.transmittance.standard_error);
}

// The same seed gives the same numbers for any number of threads; another seed gives others within their
// errors.
TEST(MonteCarlo, IsReproducible) {
  MonteCarloScene scene;
  scene.stack = {1.0, {{.mu_a = 1.0, .mu_s = 5.0, .n = 1.4}}, 1.4};
  const auto one = RunMonteCarlo(scene, {.photons = 60000, .seed = 5, .threads = 1});
  const auto three = RunMonteCarlo(scene, {.photons = 60000, .seed = 5, .threads = 3});
  const auto other = RunMonteCarlo(scene, {.photons = 60000, .seed = 6, .threads = 1});
  EXPECT_EQ(one.reflectance.value, three.reflectance.value);
  EXPECT_NE(one.reflectance.value, other.reflectance.value);
  EXPECT_NEAR(one.reflectance.value, other.reflectance.value,
              4 * std::hypot(one.reflectance.standard_error, other.reflectance.standard_error));
}

// Rings that cover everything hold the total; source: addition.
TEST(MonteCarlo, RingsSumToTheTotal) {
  MonteCarloScene scene;
  scene.stack = {1.0, {{.mu_a = 1.0, .mu_s = 5.0, .n = 1.4}}, 1.4};
  scene.radial_edges_mm = {0.0, 0.1, 0.3, 1.0, 100.0};
  const auto r = RunMonteCarlo(scene, {.photons = 40000, .seed = 5});
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double inner = scene.radial_edges_mm[i], outer = scene.radial_edges_mm[i + 1];
    sum += r.radial_reflectance[i].value * std::numbers::pi * (outer * outer - inner * inner);
  }
  EXPECT_NEAR(sum, r.reflectance.value, 1e-12);
}

MonteCarloScene Patch(double mu_a_left, double mu_a_right) {
  MonteCarloScene scene;
  scene.stack = {1.0, {{.mu_a = mu_a_left, .mu_s = 5.0, .n = 1.4}}, 1.4};
  scene.beam = Beam::kWindow;
  scene.width = 8;
  scene.height = 4;
  scene.pixel_size_mm = 2.0;
  PlaneF mu_a(8, 4, static_cast<float>(mu_a_left));
  for (int y = 0; y < 4; ++y) {
    for (int x = 4; x < 8; ++x) mu_a(x, y) = static_cast<float>(mu_a_right);
  }
  scene.mu_a = {mu_a};
  scene.periodic = true;
  return scene;
}

// A map that is uniform is the layer's own absorption, photon by photon; source: the same walk without a map.
TEST(MonteCarlo, UniformMapIsNoMap) {
  MonteCarloScene mapped = Patch(1.0, 1.0), plain = mapped;
  plain.mu_a.clear();
  const auto a = RunMonteCarlo(mapped, {.photons = 20000, .seed = 2});
  const auto b = RunMonteCarlo(plain, {.photons = 20000, .seed = 2});
  EXPECT_NEAR(a.reflectance.value, b.reflectance.value, 1e-6);
}

// Far from an edge between two skins each is like itself; source: adding-doubling of each.
TEST(MonteCarlo, MapsAbsorbWhereTheySay) {
  const auto r = RunMonteCarlo(Patch(0.5, 4.0), {.photons = 200000, .seed = 3});
  for (const auto& [x, mu_a] : {std::pair{1, 0.5}, std::pair{5, 4.0}}) {
    const Totals uniform = NormalIncidenceTotals({1.0, {{.mu_a = mu_a, .mu_s = 5.0, .n = 1.4}}, 1.4});
    for (const int y : {0, 2}) {
      EXPECT_NEAR(r.reflectance_image(x, y), uniform.reflectance, 4 * r.reflectance_image_error(x, y))
          << x << ' ' << y;
    }
  }
}

// Black tape takes light that free tape would mirror back; source: the definition of the two.
TEST(MonteCarlo, BlackTapeDarkensTheWindow) {
  MonteCarloScene scene = Patch(0.1, 0.1);
  scene.pixel_size_mm = 0.2;
  scene.periodic = false;
  const auto free = RunMonteCarlo(scene, {.photons = 40000, .seed = 4});
  scene.black_tape = true;
  const auto black = RunMonteCarlo(scene, {.photons = 40000, .seed = 4});
  const auto mean = [](const MonteCarloResult& r) {
    double sum = 0.0, variance = 0.0;
    for (std::size_t i = 0; i < r.reflectance_image.size(); ++i) {
      sum += r.reflectance_image.values()[i];
      variance += std::pow(r.reflectance_image_error.values()[i], 2);
    }
    const auto count = static_cast<double>(r.reflectance_image.size());
    return Estimate{sum / count, std::sqrt(variance) / count};
  };
  EXPECT_GT(mean(free).value,
            mean(black).value + 3 * std::hypot(mean(free).standard_error, mean(black).standard_error));
}

}  // namespace
}  // namespace dermap::reference
