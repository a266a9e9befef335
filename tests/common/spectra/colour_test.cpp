// SPDX-License-Identifier: Apache-2.0
// Colour against the published tables and matrices of CIE and IEC.
#include "common/spectra/colour.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"

namespace dermap {
namespace {

const std::filesystem::path kSpectra = "config/spectra";

double ChromaticityX(const Xyz& xyz) {
  return xyz[0] / (xyz[0] + xyz[1] + xyz[2]);
}
double ChromaticityY(const Xyz& xyz) {
  return xyz[1] / (xyz[0] + xyz[1] + xyz[2]);
}

// CIE 015:2018, table 11.3 (and ISO/CIE 11664-2): chromaticities of D65, D50 and A for the 2 degree observer.
TEST(Colour, IlluminantsHaveTheirPublishedWhitePoints) {
  const ColourObserver d65(kSpectra, Illuminant::kD65), d50(kSpectra, Illuminant::kD50),
      a(kSpectra, Illuminant::kA);
  EXPECT_NEAR(ChromaticityX(d65.white()), 0.31272, 5e-5);
  EXPECT_NEAR(ChromaticityY(d65.white()), 0.32903, 5e-5);
  EXPECT_NEAR(ChromaticityX(d50.white()), 0.34567, 5e-5);
  EXPECT_NEAR(ChromaticityY(d50.white()), 0.35851, 5e-5);
  EXPECT_NEAR(ChromaticityX(a.white()), 0.44758, 5e-5);
  EXPECT_NEAR(ChromaticityY(a.white()), 0.40745, 5e-5);
  EXPECT_NEAR(d65.white()[1], 1.0, 1e-12);
}

// IEC 61966-2-1:1999, eq. (6): its matrix has four decimals and inverts a rounded one, hence the tolerance.
TEST(Colour, LinearSrgbIsTheStandardsMatrix) {
  const double expected[3][3] = {
      {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};
  for (int column = 0; column < 3; ++column) {
    Xyz unit{};
    unit[static_cast<std::size_t>(column)] = 1.0;
    const LinearRgb rgb = LinearSrgbFromXyz(unit);
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(rgb[static_cast<std::size_t>(row)], expected[row][column], 5e-4);
  }
}

// IEC 61966-2-1:1999, section 5.2: 12.92 c up to 0.0031308, then 1.055 c^(1/2.4) - 0.055. Linear 0.2140 is
// the middle of the 8-bit scale's neighbour 127.5 (0.5 encoded), a figure quoted in most descriptions of
// sRGB.
TEST(Colour, TransferCurveIsTheStandards) {
  EXPECT_NEAR(EncodeSrgb(0.0031308), 0.04045, 1e-5);
  EXPECT_NEAR(EncodeSrgb(0.001), 0.01292, 1e-12);
  EXPECT_NEAR(EncodeSrgb(0.21404), 0.5, 1e-4);
  EXPECT_EQ(EncodeSrgb8(0.0), 0);
  EXPECT_EQ(EncodeSrgb8(1.0), 255);
  EXPECT_EQ(EncodeSrgb8(-0.2), 0);
  EXPECT_EQ(EncodeSrgb8(3.0), 255);
}

// B. Lindbloom, "Chromatic Adaptation": Bradford matrix from D65 to D50, first and third column.
TEST(Colour, BradfordMatchesThePublishedMatrix) {
  const Xyz d65{0.95047, 1.0, 1.08883}, d50{0.96422, 1.0, 0.82521};
  const Xyz x = AdaptWhite({1.0, 0.0, 0.0}, d65, d50);
  EXPECT_NEAR(x[0], 1.0478112, 1e-5);
  EXPECT_NEAR(x[1], 0.0295424, 1e-5);
  EXPECT_NEAR(x[2], -0.0092345, 1e-5);
  const Xyz z = AdaptWhite({0.0, 0.0, 1.0}, d65, d50);
  EXPECT_NEAR(z[0], -0.0501270, 1e-5);
  EXPECT_NEAR(z[1], -0.0170491, 1e-5);
  EXPECT_NEAR(z[2], 0.7521316, 1e-5);
}

// By definition: the perfect reflector is white, whatever the bands and the light.
TEST(Colour, ReflectanceOneIsExactlyWhite) {
  for (const Illuminant illuminant : {Illuminant::kD65, Illuminant::kD50, Illuminant::kA}) {
    const ColourObserver observer(kSpectra, illuminant);
    for (const auto& bands :
         {std::vector<double>{550}, std::vector<double>{450, 480, 510, 540, 560, 580, 610, 650},
          std::vector<double>{360, 900}}) {
      const LinearRgb rgb = observer.LinearSrgbOf(bands, std::vector<double>(bands.size(), 1.0));
      for (const double c : rgb) EXPECT_NEAR(c, 1.0, 1e-9);
    }
  }
}

// A spectrum that is itself piecewise linear at the bands and constant beyond must give what dense sampling
// of it gives.
TEST(Colour, InterpolatesLinearlyAndHoldsTheEnds) {
  const ColourObserver observer(kSpectra);
  const std::vector<double> bands{450, 520, 600.5, 650};
  const std::vector<double> values{0.1, 0.5, 0.2, 0.9};
  std::vector<double> dense_nm, dense;
  for (double nm = 350; nm <= 840; nm += 0.5) {
    dense_nm.push_back(nm);
    double value = nm < 450 ? 0.1 : 0.9;
    for (std::size_t i = 0; i + 1 < bands.size(); ++i) {
      if (nm < bands[i] || nm > bands[i + 1]) continue;
      value = values[i] + (values[i + 1] - values[i]) * (nm - bands[i]) / (bands[i + 1] - bands[i]);
    }
    dense.push_back(value);
  }
  const Xyz few = observer.XyzOf(bands, values), many = observer.XyzOf(dense_nm, dense);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(few[static_cast<std::size_t>(i)], many[static_cast<std::size_t>(i)], 1e-9);
}

// Everyday knowledge: 450 nm is blue, 540 nm green, 620 nm red; ultraviolet has no colour.
TEST(Colour, WavelengthsHaveTheirHues) {
  const ColourObserver observer(kSpectra);
  const Rgb8 blue = observer.WavelengthColour(450), green = observer.WavelengthColour(540);
  const Rgb8 red = observer.WavelengthColour(620), none = observer.WavelengthColour(355);
  EXPECT_TRUE(blue[2] == 255 && blue[2] > blue[0] && blue[0] > blue[1]);
  EXPECT_TRUE(green[1] == 255 && green[1] > green[0] && green[1] > green[2]);
  EXPECT_TRUE(red[0] == 255 && red[0] > red[1]);
  EXPECT_EQ(none, (Rgb8{128, 128, 128}));
}

// Linearity of the integral; NaN marks a pixel without a value (picture contract in colour.h).
TEST(Colour, PictureIsPixelwiseAndMarksMissingBands) {
  const ColourObserver observer(kSpectra);
  const std::vector<double> bands{450, 550, 650};
  std::vector<PlaneF> planes(3, PlaneF(2, 2, 0.5f));
  planes[0](1, 0) = 0.05f;
  planes[1](0, 1) = NAN;
  const Plane<Rgb8> picture = observer.Picture(bands, planes);
  EXPECT_EQ(picture(0, 0),
            (Rgb8{188, 188, 188}));               // IEC 61966-2-1: 255 (1.055 * 0.5^(1/2.4) - 0.055) = 187.5
  EXPECT_LT(picture(1, 0)[2], picture(1, 0)[0]);  // less blue: yellowish
  EXPECT_EQ(picture(0, 1), kMissingColour);
  EXPECT_EQ(observer.Picture(bands, planes, 2.0)(0, 0), (Rgb8{255, 255, 255}));
}

// The contract of colour.h.
TEST(Colour, RefusesBandsOutOfOrder) {
  const ColourObserver observer(kSpectra);
  EXPECT_THROW(observer.BandWeights(std::vector<double>{}), InputError);
  EXPECT_THROW(observer.BandWeights(std::vector<double>{500, 450}), InputError);
  EXPECT_THROW(observer.BandWeights(std::vector<double>{500, NAN}), InputError);
}

}  // namespace
}  // namespace dermap
