// SPDX-License-Identifier: Apache-2.0
// A small program that makes new truth: totals, rings and images of any stack of layers, as JSON on stdout.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/reference/adding_doubling.h"
#include "tests/reference/monte_carlo.h"

namespace {

using dermap::PlaneF;
using namespace dermap::reference;
using nlohmann::json;

// "thickness_mm,mu_a,mu_s,g,n[,absorbance below]"; thickness inf for a half-space.
Layer ParseLayer(const std::string& text) {
  std::vector<double> v;
  std::stringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');) v.push_back(std::stod(item));
  if (v.size() < 5 || v.size() > 6)
    throw CLI::ValidationError("--layer", "takes 5 or 6 numbers, not '" + text + "'");
  return {v[0], v[1], v[2], v[3], v[4], v.size() == 6 ? v[5] : 0.0};
}

// Rows of comma-separated numbers, all of one length.
PlaneF ReadMap(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw CLI::ValidationError("--mu-a-map", "cannot read " + path);
  std::vector<float> values;
  int height = 0;
  for (std::string line; std::getline(file, line); ++height) {
    std::stringstream stream(line);
    for (std::string item; std::getline(stream, item, ',');) values.push_back(std::stof(item));
  }
  if (height == 0 || values.size() % height != 0)
    throw CLI::ValidationError("--mu-a-map", path + " is not a grid");
  PlaneF map(static_cast<int>(values.size()) / height, height);
  std::copy(values.begin(), values.end(), map.data());
  return map;
}

json Json(const Estimate& e) {
  return {{"value", e.value}, {"standard_error", e.standard_error}};
}
json Json(const std::vector<Estimate>& list) {
  json out = json::array();
  for (const Estimate& e : list) out.push_back(Json(e));
  return out;
}

void WriteImage(const std::string& path, const dermap::Plane<double>& image) {
  std::ofstream file(path);
  file.precision(8);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) file << (x > 0 ? "," : "") << image(x, y);
    file << '\n';
  }
  if (!file) throw std::runtime_error("cannot write " + path);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Monte Carlo of light in plane layers: truth with standard errors");
  MonteCarloScene scene;
  MonteCarloOptions options;
  std::vector<std::string> layers, maps;
  std::string image;
  app.add_option("--layer", layers, "thickness_mm,mu_a,mu_s,g,n[,absorbance below]; from the top")
      ->required();
  app.add_option("--n-above", scene.stack.n_above, "refractive index above (default 1)");
  app.add_option("--n-below", scene.stack.n_below, "refractive index below (default 1)");
  app.add_option("--photons", options.photons, "number of photons");
  app.add_option("--seed", options.seed, "seed of the random numbers");
  app.add_option("--threads", options.threads, "threads (the result is the same for any number)");
  app.add_option("--radial-mm", scene.radial_edges_mm, "edges of the rings of R(r) and T(r)")->delimiter(',');
  app.add_option("--mu-a-map", maps,
                 "one CSV grid a layer, 1/mm (or - for none): makes a window of its size");
  app.add_option("--pixel-size-mm", scene.pixel_size_mm, "of the maps");
  app.add_flag("--periodic", scene.periodic, "the light and the maps go on beyond the window");
  app.add_flag("--black-tape", scene.black_tape, "beyond the window the surface absorbs from below");
  app.add_option("--image", image, "writes PATH.csv and PATH.error.csv, reflectance by pixel");
  CLI11_PARSE(app, argc, argv);
  try {
    for (const std::string& layer : layers) scene.stack.layers.push_back(ParseLayer(layer));
    for (const std::string& map : maps) scene.mu_a.push_back(map == "-" ? PlaneF() : ReadMap(map));
    for (const PlaneF& map : scene.mu_a) {
      if (map.empty()) continue;
      scene.beam = Beam::kWindow;
      scene.width = map.width();
      scene.height = map.height();
    }
    if (scene.beam == Beam::kWindow && !(scene.pixel_size_mm > 0.0)) {
      throw CLI::ValidationError("--pixel-size-mm", "must be above 0 where there is a map");
    }
    scene.mu_a.resize(scene.mu_a.empty() ? 0 : scene.stack.layers.size());
    const MonteCarloResult r = RunMonteCarlo(scene, options);
    json out{{"photons", r.photons},
             {"seed", r.seed},
             {"specular", r.specular},
             {"reflectance", Json(r.reflectance)},
             {"transmittance", Json(r.transmittance)},
             {"ballistic", Json(r.ballistic)},
             {"single_scattering", Json(r.single_scattering)}};
    if (scene.radial_edges_mm.size() > 1) {
      out["radial_edges_mm"] = scene.radial_edges_mm;
      out["radial_reflectance_per_mm2"] = Json(r.radial_reflectance);
      out["radial_transmittance_per_mm2"] = Json(r.radial_transmittance);
    }
    if (scene.mu_a.empty()) {
      const Totals totals = NormalIncidenceTotals(scene.stack);
      out["adding_doubling"] = {{"reflectance", totals.reflectance}, {"transmittance", totals.transmittance}};
    }
    if (!image.empty() && scene.width > 0) {
      WriteImage(image + ".csv", r.reflectance_image);
      WriteImage(image + ".error.csv", r.reflectance_image_error);
    }
    std::cout << out.dump(2) << '\n';
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
  return 0;
}
