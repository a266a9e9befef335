// SPDX-License-Identifier: Apache-2.0
// Measured spectra as a table of text, one a row or one a column, or as the pixels of a stack; reflectance as
// a fraction.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/stack.h"

namespace dermap {

struct MeasuredSpectra {
  std::vector<double> wavelengths_nm;  // strictly ascending
  std::vector<std::string> label_names;
  struct Row {
    std::vector<std::string> labels;  // as many as label_names; the first is the spectrum's name
    std::vector<double> reflectance;  // one a wavelength
    std::vector<double> sigma;        // likewise, or empty where the file does not say
  };
  std::vector<Row> rows;  // at least one
};

struct SpectraFormat {
  std::string layout = "auto";  // auto | rows | columns
  bool per_cent = false;        // numbers are per cent
  double from_nm = 400.0, to_nm = 720.0;
};

// Layout `rows`: a column for each wavelength, named by it (450, R450, 450 nm, ...), all other columns are
// labels; `columns`: the first column holds wavelengths, every other one is a spectrum; `auto` tells them by
// the first name. Wavelengths outside from_nm...to_nm are left out. Throws InputError that names file, line
// and column.
MeasuredSpectra ReadSpectra(const std::filesystem::path& path, const SpectraFormat& format);

// Every valid pixel a spectrum, labelled by column and row; `name` is the file, for messages.
MeasuredSpectra SpectraOfStack(const ReflectanceStack& stack, const SpectraFormat& format,
                               std::string_view name);

}  // namespace dermap
