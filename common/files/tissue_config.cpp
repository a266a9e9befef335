// SPDX-License-Identifier: Apache-2.0
// The [tissue] table: keys of TissueConfig, whose own validation knows the ranges.
#include "common/files/tissue_config.h"

#include <limits>

#include "common/core/error.h"

namespace dermap {

TissueConfig ReadTissueTable(TomlTable& file, const TissueConfig& defaults) {
  TissueConfig config = defaults;
  auto table = file.Table("tissue");
  if (!table) return config;
  constexpr double kAny = std::numeric_limits<double>::max();
  const auto read = [&](const char* key, double& value) { value = table->Number(key, value, -kAny, kAny); };
  read("epidermis_thickness_mm", config.epidermis_thickness_mm);
  read("n_epidermis", config.n_epidermis);
  read("n_dermis", config.n_dermis);
  read("n_outside", config.n_outside);
  read("oxygenation_epidermis", config.oxygenation_epidermis);
  read("oxygenation_dermis", config.oxygenation_dermis);
  read("junction_absorbance", config.junction_absorbance);
  read("scattering_amplitude", config.scattering_amplitude);
  read("scattering_slope", config.scattering_slope);
  read("anisotropy", config.anisotropy);
  table->Finish();
  try {
    Validate(config);
  } catch (const InputError& error) {
    throw InputError(file.Where("tissue") + ", [tissue]: " + error.what());
  }
  return config;
}

TissueConfig ReadTissueConfig(const std::filesystem::path& path, const TissueConfig& defaults) {
  TomlTable file = TomlTable::ReadFile(path);
  const TissueConfig config = ReadTissueTable(file, defaults);
  file.Finish();
  return config;
}

}  // namespace dermap
