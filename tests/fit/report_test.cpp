// SPDX-License-Identifier: Apache-2.0
// The report is one file, complete, escaped, and drawn for any size; the sources of its figures are in the
// sample.
#include "fit/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/picture.h"
#include "tests/common/files/temporary_folder.h"
#include "tests/fit/report/html_check.h"
#include "tests/fit/report/sample_fit.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

ReportInput InputFor(const FitResult& fit) {
  return {
      .fit = fit, .name = "sample.exr", .spectra_dir = "config/spectra", .truth = nullptr, .calibration = {}};
}

std::string Written(const ReportInput& input) {
  const TemporaryFolder folder;
  WriteReport(folder / "report.html", input);
  EXPECT_EQ(folder.Names().size(), 1u) << "nothing but the page";
  return ReadTextFile(folder / "report.html");
}

// The list of sections in the report's contract.
TEST(Report, HasEverySection) {
  const SampleFit sample = MakeSampleFit(24, 24);
  const std::string html = Written(InputFor(sample.fit));
  for (const char* id : {"colour", "captured", "stack", "maps", "pixel", "comparison", "residual",
                         "convergence", "flags", "decisions", "reading"}) {
    EXPECT_EQ(CountOf(html, std::string("<section id=\"") + id + "\""), 1) << id;
    EXPECT_EQ(CountOf(html, std::string("href=\"#") + id + "\""), 1) << id;
  }
  const std::string text = VisibleText(html);
  for (const char* words :
       {"sample.exr", "rms residual", "chi2 per degree of freedom", "descent", "multipole", "pyramid",
        "24 x 24", "450 nm", "650 nm", "sigma of C_hd", "volume fraction", "235 renders", "12.3 s",
        "converged", "reduced size to stay within 60 s"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
}

// "Self-contained, opens without a network" (the fit folder's contract).
TEST(Report, FetchesNothing) {
  const SampleFit sample = MakeSampleFit(16, 16);
  ReportInput input = InputFor(sample.fit);
  input.truth = &sample.truth;
  EXPECT_THAT(OutsideReferences(Written(input)), IsEmpty());
}

// A page has its own script and data, no more than 64 x 64 pixels of them: 8 bands by 3 planes, 5 maps by 2
// and the flags in 2 bytes each and base64, 382 kB. Names cannot end the script's element.
TEST(Report, HoldsThePixelsValues) {
  SampleFit sample = MakeSampleFit(200, 130);
  sample.fit.measured[0](101, 66) = std::nanf("");
  const std::string html = Written(InputFor(sample.fit));
  const std::string open = "id=\"pixel-values\">";
  const auto begin = html.find(open) + open.size();
  EXPECT_EQ(html.find("</script>", begin) - begin, (50u * 32u * (8 * 3 + 5 * 2 + 1) * 2 + 2) / 3 * 4);
  EXPECT_THAT(html, HasSubstr("\"step\":4"));
  EXPECT_THAT(html, HasSubstr("\"width\":50"));
  EXPECT_LT(html.size(), 3'000'000u);
}

// HTML: elements close in order.
TEST(Report, IsWellFormed) {
  const SampleFit sample = MakeSampleFit(16, 16);
  ReportInput input = InputFor(sample.fit);
  EXPECT_THAT(NestingFaults(Written(input)), IsEmpty());
  input.truth = &sample.truth;
  EXPECT_THAT(NestingFaults(Written(input)), IsEmpty());
}

// Strings come from file names and configuration, so they may hold anything.
TEST(Report, EscapesEveryString) {
  SampleFit sample = MakeSampleFit(16, 16);
  const std::string evil = "<script>alert(\"1\")</script>&amp;'";
  sample.fit.method = sample.fit.profiles = sample.fit.engine = evil;
  sample.fit.decisions = {evil};
  const TemporaryFolder folder;
  folder.Write("s.calibration.json", R"({"session": "<script>x", "correlation": "<b>",
    "bands": [{"wavelength_nm": "<i>", "frame": "<script>y", "notes": ["<u>", 3, null, {"a": "<s>"}]}],
    "pictures": [{"title": "<script>z", "file": "<script>.png"}, {"title": 7}, "rubbish"]})");
  ReportInput input = InputFor(sample.fit);
  input.name = evil;
  input.calibration = folder / "s.calibration.json";
  const std::string html = Written(input);
  EXPECT_THAT(OutsideReferences(html), IsEmpty());
  EXPECT_THAT(NestingFaults(html), IsEmpty());
  EXPECT_EQ(CountOf(html, "<script"), 3);  // the page's own
  EXPECT_EQ(CountOf(html, "&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;&amp;amp;&#39;"), 6);
}

// Arithmetic: maps that are the truth times 1.1 have a median and a 90th percentile of 10 %. The truth has
// twice the size.
TEST(Report, StatesTheErrorAgainstTheTruth) {
  SampleFit sample = MakeSampleFit(20, 20);
  for (PlaneF& plane : sample.fit.maps.planes)
    std::fill(plane.values().begin(), plane.values().end(), 0.044f);
  for (PlaneF& plane : sample.truth.maps.planes)
    std::fill(plane.values().begin(), plane.values().end(), 0.04f);
  ReportInput input = InputFor(sample.fit);
  input.truth = &sample.truth;
  const std::string text = VisibleText(Written(input));
  EXPECT_EQ(CountOf(text, "relative error: median 10 %, 90th percentile 10 %"), 5);
  EXPECT_THAT(text, HasSubstr("True C_m"));
  EXPECT_THAT(text, HasSubstr("within 1 sigma"));
}

// The record's keys are those that `calibrate` documents; pictures must end up inside the page.
TEST(Report, ShowsTheCalibrationRecord) {
  const SampleFit sample = MakeSampleFit(16, 16);
  const TemporaryFolder folder;
  WritePng(folder / "stack.calibration" / "a.png", Plane<Rgb8>(5, 4, Rgb8{1, 2, 3}));
  folder.Write("stack.calibration.json",
               R"({"session": "arm-01", "bands": [{"wavelength_nm": 450.0, "frame": "frames/7.dng",
    "gray_card_drift": 1.0123, "alignment_shift_px": [0.25, -0.5], "median_noise": 0.0041, "saturated_share": 0.02,
    "notes": ["one", "two"], "systematic_sigma": 0.005, "steps": [
    {"step": "flash-drift", "applied": true, "effect": -0.0172, "sigma": 0.00014, "note": ""},
    {"step": "gel", "applied": false, "effect": 0.0, "sigma": 0.0, "note": "the rig states none"}]}], "pictures": [{"title": "As captured, 450 nm", "file": "stack.calibration/a.png"},
    {"title": "Stray", "file": "../../etc/passwd"}, {"title": "Lost", "file": "lost.png"}]})");
  EXPECT_EQ(CalibrationSidecar(folder / "other.exr"), std::nullopt);
  ReportInput input = InputFor(sample.fit);
  input.calibration = CalibrationSidecar(folder / "stack.exr");
  ASSERT_TRUE(input.calibration.has_value());
  const std::string html = Written(input), text = VisibleText(html);
  for (const char* words : {"arm-01", "frames/7.dng", "1.01", "0.25, -0.5", "0.0041", "2 %", "one; two",
                            "As captured, 450 nm", "outside its folder", "lost.png", "flash-drift",
                            "-1.72 % \u00b1 0.014 %", "no: the rig states none", "\u00b1 0.5 %"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
  const auto png = ReadBinaryFile(folder / "stack.calibration" / "a.png");
  EXPECT_THAT(html, HasSubstr(DataUri(png)));
}

// A sidecar that cannot be read must not cost the report (report.h).
TEST(Report, SurvivesABrokenRecord) {
  const SampleFit sample = MakeSampleFit(16, 16);
  const TemporaryFolder folder;
  ReportInput input = InputFor(sample.fit);
  for (const char* contents : {"", "{", "[1, 2]", "{\"bands\": 3, \"pictures\": {}}", "\xff\xfe"}) {
    input.calibration = folder.Write("x.calibration.json", contents);
    EXPECT_THAT(NestingFaults(Written(input)), IsEmpty()) << contents;
  }
  input.calibration = folder / "absent.json";
  EXPECT_THAT(VisibleText(Written(input)), HasSubstr("absent.json"));
}

// The smallest patch, narrow ones, one band, a short history, and missing pixels.
TEST(Report, DrawsAnySize) {
  for (const auto& [width, height, bands] :
       {std::array{1, 1, 1}, std::array{3, 200, 2}, std::array{300, 5, 8}}) {
    SampleFit sample = MakeSampleFit(width, height, bands);
    sample.fit.history.resize(1);
    sample.fit.measured[0](0, 0) = NAN;
    ReportInput input = InputFor(sample.fit);
    input.truth = &sample.truth;
    const std::string html = Written(input);
    EXPECT_THAT(NestingFaults(html), IsEmpty()) << width << ' ' << height;
    EXPECT_THAT(html, Not(HasSubstr(">nan"))) << width << ' ' << height;
  }
  SampleFit bare = MakeSampleFit(8, 8, 1);
  bare.fit.history.clear();
  bare.fit.flags = {};
  bare.fit.chi2_map = {};
  bare.fit.noise.clear();
  bare.fit.decisions.clear();
  bare.fit.converged = false;
  EXPECT_THAT(NestingFaults(Written(InputFor(bare.fit))), IsEmpty());
  EXPECT_THAT(VisibleText(Written(InputFor(bare.fit))), HasSubstr("not converged"));
}

// A 256 x 256 patch of 8 bands is what a capture gives; its page must stay small enough to send by mail.
TEST(Report, FullSizeIsSmallEnoughToSend) {
  const SampleFit sample = MakeSampleFit(256, 256);
  ReportInput input = InputFor(sample.fit);
  input.truth = &sample.truth;
  EXPECT_LT(Written(input).size(), 10u << 20);
}

// One preview a map, one of its sigma where it was free, chi2 and colour (report.h).
TEST(Report, WritesPreviews) {
  const SampleFit sample = MakeSampleFit(16, 16);
  const TemporaryFolder folder;
  WriteMapPreviews(folder.path(), sample.fit, "config/spectra");
  EXPECT_THAT(folder.Names(),
              ::testing::UnorderedElementsAre("C_m.png", "C_m.sigma.png", "beta_m.png", "beta_m.sigma.png",
                                              "C_he.png", "C_he.sigma.png", "C_bc.png", "C_hd.png",
                                              "C_hd.sigma.png", "chi2.png", "colour.png"));
}

// A folder that is a file cannot be written into: storage, and nothing left behind.
TEST(Report, UnwritablePlaceIsAStorageError) {
  const SampleFit sample = MakeSampleFit(8, 8);
  const TemporaryFolder folder;
  folder.Write("file", "x");
  EXPECT_THROW(WriteReport(folder / "file/report.html", InputFor(sample.fit)), StorageError);
  EXPECT_EQ(folder.Names().size(), 1u);
}

}  // namespace
}  // namespace dermap
