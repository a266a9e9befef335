// SPDX-License-Identifier: Apache-2.0
// What is free in a fit: chosen by the caller, by the evidence or the number of bands, or carried by a prior.
#pragma once

#include <string>
#include <vector>

#include "fit/options.h"

namespace dermap {

// As asked for; under a prior all that it was learnt for, which it carries where the bands do not tell.
// Empty: nobody asked.
std::vector<Parameter> AskedFor(const FitOptions& options);

// Without a prior ChooseFreeParameters; with one AskedFor. Throws InputError for a method that knows no
// prior.
std::vector<Parameter> FreeFor(const FitOptions& options, int band_count,
                               std::vector<std::string>& decisions);

}  // namespace dermap
