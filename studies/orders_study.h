// SPDX-License-Identifier: Apache-2.0
// How many terms of the inter-scattering series a band needs, remade from [D08 fig. 9]: what is left of the
// reflectance after each term, for the least and the most absorbing skin of table 1, with and without the
// closed rest.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "studies/verdict.h"

namespace dermap {

struct OrdersStudyOptions {
  bool quick = false;  // three bands and a small patch: for tests
};

struct OrdersStudy {
  // Relative errors of one skin in one band against 40 terms, [term]: term 0 is Phi * R1+ alone.
  struct Curve {
    std::string skin;
    double wavelength_nm = 0.0;
    std::vector<double> open;     // series that simply end, rms over a lit window
    std::vector<double> closed;   // the rest added as if skin were uniform
    std::vector<double> uniform;  // series that end, under wide light, by closed forms: what [D08] plots
    int automatic_terms = 0;      // what the engine takes
    int terms_99 = 0;             // fewest whose open series holds 99 % of the light, [D08 7]'s criterion
  };
  std::vector<Curve> curves;
  std::vector<Verdict> verdicts;
};

OrdersStudy RunOrdersStudy(const OrdersStudyOptions& options, const ProgressFunction& progress);

// orders.csv, .json and .svg; together or not at all.
void WriteOrdersStudy(const std::filesystem::path& folder, const OrdersStudy& study);

}  // namespace dermap
