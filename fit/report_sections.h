// SPDX-License-Identifier: Apache-2.0
// The sections of the report's page, each a piece of HTML.
#pragma once

#include <string>
#include <vector>

#include "common/spectra/colour.h"
#include "fit/report.h"
#include "fit/report_calibration.h"
#include "fit/report_statistics.h"

namespace dermap {

struct ReportContext {
  const ReportInput& input;
  ColourObserver observer;
  std::vector<double> wavelengths_nm;  // of the fit's bands
  std::vector<ReportedMap> maps;
  std::vector<NamedPoint> points;
  CalibrationRecord calibration;

  const FitResult& fit() const { return input.fit; }
};
ReportContext MakeReportContext(const ReportInput& input);

// Where the truth is known: how often it lies within so many sigma, beside how often it should.
std::string DrawErrorBarChart(const ReportContext& context);

std::string HeadlineSection(const ReportContext& context);  // title, verdict and the tiles
std::string ColourSection(const ReportContext& context);
std::string CapturedSection(const ReportContext& context);
std::string StackSection(const ReportContext& context);
std::string MapsSection(const ReportContext& context);
std::string PixelSection(const ReportContext& context);
std::string ComparisonSection(const ReportContext& context);
std::string ResidualSection(const ReportContext& context);
std::string ConvergenceSection(const ReportContext& context);
std::string FlagsSection(const ReportContext& context);
std::string DecisionsSection(const ReportContext& context);
std::string HowToReadSection();

// "450 nm" with a dot of that colour.
std::string BandLabel(const ReportContext& context, std::size_t band);

}  // namespace dermap
