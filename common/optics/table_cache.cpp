// SPDX-License-Identifier: Apache-2.0
// One file a band: magic, version, length of the recipe, recipe, correction as float64, weights and
// transforms as float32, SHA-256 of all before.
#include "common/optics/table_cache.h"

#include <openssl/evp.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace dermap {
namespace {

constexpr std::string_view kMagic = "dermap-tables\n";
// To be raised whenever the optics, the frequencies or the fit of Gaussians change what a recipe leads to.
constexpr std::uint32_t kVersion = 4;
constexpr std::size_t kDigestSize = 32;
constexpr std::array kTables{&BandTables::r1_forward,   &BandTables::t1_forward,
                             &BandTables::t1_ballistic, &BandTables::r1_backward,
                             &BandTables::t1_backward,  &BandTables::r1_backward_black,
                             &BandTables::r2_diffuse,   &BandTables::r2_normal};

std::string Sha256(std::string_view bytes) {
  std::array<unsigned char, kDigestSize> digest{};
  unsigned int size = 0;
  EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
  return {digest.begin(), digest.end()};
}

std::string Hex(std::string_view bytes) {
  std::string hex;
  for (const char byte : bytes) hex += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return hex;
}

template <class T>
void AppendRaw(std::string& to, const T& value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string Header(const std::string& recipe) {
  std::string header(kMagic);
  AppendRaw(header, kVersion);
  AppendRaw(header, static_cast<std::uint32_t>(recipe.size()));
  return header + recipe;
}

std::string Serialized(const std::string& recipe, const BandTables& tables) {
  std::string bytes = Header(recipe);
  AppendRaw(bytes, tables.wavelength_nm);
  AppendRaw(bytes, tables.correction.coefficients);
  for (const auto table : kTables) {
    for (const GaussianWeights& entry : (tables.*table).entries()) AppendRaw(bytes, entry);
    for (const float value : (tables.*table).transforms().values()) AppendRaw(bytes, value);
  }
  return bytes + Sha256(bytes);
}

constexpr std::string_view kTotalsOnly = "totals of ";

std::optional<BandTables> Parsed(std::string_view bytes, const std::string& recipe) {
  const std::string header = Header(recipe);
  // Every table but the ballistic one, which does not spread, has its transforms.
  const std::size_t transform_values =
      recipe.starts_with(kTotalsOnly) ? 0 : TableFrequencies_per_mm().size() * kTableSize;
  const std::size_t body = sizeof(double) + sizeof(TotalsCorrection::coefficients) +
                           kTables.size() * kTableSize * sizeof(GaussianWeights) +
                           (kTables.size() - 1) * transform_values * sizeof(float);
  if (bytes.size() != header.size() + body + kDigestSize || !bytes.starts_with(header)) return std::nullopt;
  if (Sha256(bytes.substr(0, header.size() + body)) != bytes.substr(header.size() + body))
    return std::nullopt;
  const char* at = bytes.data() + header.size();
  BandTables tables;
  std::memcpy(&tables.wavelength_nm, at, sizeof(double));
  at += sizeof(double);
  std::memcpy(&tables.correction.coefficients, at, sizeof(TotalsCorrection::coefficients));
  at += sizeof(TotalsCorrection::coefficients);
  for (const auto table : kTables) {
    std::vector<GaussianWeights> entries(kTableSize);
    std::memcpy(entries.data(), at, kTableSize * sizeof(GaussianWeights));
    at += kTableSize * sizeof(GaussianWeights);
    std::vector<float> transforms(table == &BandTables::t1_ballistic ? 0 : transform_values);
    if (!transforms.empty()) std::memcpy(transforms.data(), at, transforms.size() * sizeof(float));
    at += transforms.size() * sizeof(float);
    tables.*table = transforms.empty()
                        ? ProfileTable(std::move(entries))
                        : ProfileTable(std::move(entries), TransformTable(std::move(transforms)));
  }
  return tables;
}

}  // namespace

std::filesystem::path TableCacheDirectory() {
  const auto value = [](const char* name) {
    const char* text = std::getenv(name);
    return std::filesystem::path(text == nullptr ? "" : text);
  };
  if (const auto own = value("DERMAP_CACHE_DIR"); !own.empty()) return own;
  if (const auto xdg = value("XDG_CACHE_HOME"); !xdg.empty()) return xdg / "dermap";
  if (const auto home = value("HOME"); !home.empty()) return home / ".cache" / "dermap";
  return {};
}

TableCache::TableCache(std::filesystem::path directory) : directory_(std::move(directory)) {}

std::string TableCache::Recipe(std::string_view source, double wavelength_nm, const TissueConfig& config) {
  // Oxygenation and the absorber at the junction act outside the tables.
  return fmt::format(
      "source {} table {} {} {} gaussians {} {} frequencies {} wavelength_nm {} epidermis_thickness_mm {} n "
      "{} {} "
      "{} "
      "mu_s_reduced {} {} anisotropy {}",
      source, kTableSize, kTableMinMuA, kTableMaxMuA, kGaussianCount, kSmallestVariance_mm2,
      TableFrequencies_per_mm().size(), wavelength_nm, config.epidermis_thickness_mm, config.n_outside,
      config.n_epidermis, config.n_dermis, ReducedScatteringEpidermis(wavelength_nm, config),
      ReducedScatteringDermis(wavelength_nm, config), config.anisotropy);
}

std::string TableCache::TotalsRecipe(std::string_view source, double wavelength_nm,
                                     const TissueConfig& config) {
  return std::string(kTotalsOnly) + Recipe(source, wavelength_nm, config);
}

std::filesystem::path TableCache::PathOf(const std::string& recipe) const {
  return directory_ / (Hex(Sha256(Header(recipe))).substr(0, 32) + ".tables");
}

std::optional<BandTables> TableCache::Load(const std::string& recipe) const {
  if (directory_.empty()) return std::nullopt;
  const auto path = PathOf(recipe);
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  auto tables = Parsed(bytes, recipe);
  if (!tables) spdlog::info("The cached tables {} are damaged and will be built again.", path.string());
  return tables;
}

void TableCache::Store(const std::string& recipe, const BandTables& tables) const {
  if (directory_.empty()) return;
  static std::atomic<unsigned> counter{0};
  const auto path = PathOf(recipe);
  const auto temporary = path.string() + fmt::format(".partial-{}-{}", getpid(), counter++);
  std::error_code error;
  std::filesystem::create_directories(directory_, error);
  bool written = false;
  if (!error) {
    const std::string bytes = Serialized(recipe, tables);
    std::ofstream file(temporary, std::ios::binary);
    written = file.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush().good();
  }
  if (written) std::filesystem::rename(temporary, path, error);
  if (!written || error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    spdlog::info("The tables could not be kept in {}: they will be built again next time.",
                 directory_.string());
  }
}

}  // namespace dermap
