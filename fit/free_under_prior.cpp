// SPDX-License-Identifier: Apache-2.0
// Free parameters.
#include "fit/free_under_prior.h"

#include "common/core/error.h"
#include "fit/prepare.h"

namespace dermap {

std::vector<Parameter> AskedFor(const FitOptions& options) {
  if (!options.prior || !options.free_parameters.empty()) return options.free_parameters;
  return {Parameter::kC_m, Parameter::kBeta_m, Parameter::kC_he, Parameter::kC_bc, Parameter::kC_hd};
}

std::vector<Parameter> FreeFor(const FitOptions& options, int band_count,
                               std::vector<std::string>& decisions) {
  if (!options.prior) return ChooseFreeParameters(options.free_parameters, band_count, decisions);
  if (options.method != FitMethod::kFast)
    throw InputError("Method " + std::string(NameOf(options.method)) +
                     " knows no prior of earlier fits; use --method fast or leave out --prior.");
  const int fits = options.prior->fits();
  decisions.push_back("The prior of " + std::to_string(fits) + " earlier fit" + (fits == 1 ? "" : "s") +
                      " carries what the bands do not tell; sigma holds how far it may be off.");
  return AskedFor(options);
}

}  // namespace dermap
