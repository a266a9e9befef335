// SPDX-License-Identifier: Apache-2.0
// Tiles in rows, a section for each role.
#include "calibrate/session_sheet.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <vector>

#include "calibrate/frame_picture.h"
#include "calibrate/raw_frame.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr int kTileWidth = 240;
constexpr int kTileHeight = 180;
constexpr int kTitleHeight = 22;
constexpr int kColumns = 5;
constexpr Rgb8 kBackground{24, 24, 28};
constexpr Rgb8 kBadColour{150, 24, 24};

struct Tile {
  FrameRole role = FrameRole::kBlack;
  double wavelength_nm = 0.0;
  std::optional<FrameRecord> record;  // none: never taken
  std::string fault;                  // empty where the frame is good
  Plane<Rgb8> picture;
};

std::set<double> FiltersOf(const Session& session) {
  std::set<double> filters;
  for (const FrameRecord& frame : session.frames) {
    if (frame.role != FrameRole::kBlack) filters.insert(frame.wavelength_nm);
  }
  for (const PlannedExposure& planned : session.plan.exposures) {
    const WheelSlot* slot = FindSlot(session.rig, planned.slot);
    if (slot != nullptr && !slot->opaque) filters.insert(slot->wavelength_nm);
  }
  return filters;
}

std::vector<Tile> TilesOf(const Session& session) {
  std::vector<Tile> tiles;
  const auto add = [&](FrameRole role, double wavelength_nm) {
    const std::size_t before = tiles.size();
    for (const FrameRecord& frame : session.frames) {
      if (frame.role == role && (role == FrameRole::kBlack || frame.wavelength_nm == wavelength_nm))
        tiles.push_back({role, wavelength_nm, frame, "", {}});
    }
    if (tiles.size() == before) tiles.push_back({role, wavelength_nm, std::nullopt, "NEVER TAKEN", {}});
  };
  add(FrameRole::kBlack, 0.0);
  for (const FrameRole role : {FrameRole::kSpectralon, FrameRole::kSkin}) {
    for (const double nm : FiltersOf(session)) add(role, nm);
  }
  return tiles;
}

Plane<Rgb8> PictureOfFrame(const BayerFrame& frame) {
  PlaneF signal(frame.values.width(), frame.values.height());
  for (std::size_t i = 0; i < signal.size(); ++i)
    signal.data()[i] = static_cast<float>(frame.values.data()[i] - frame.black_level);
  return Colourise(PictureOf(signal, kTileWidth).picture, ColourMap::kGray, {0.0, 1.0});
}

void Look(const std::filesystem::path& folder, Tile& tile) {
  if (!tile.record) return;
  const std::filesystem::path path = folder / tile.record->file;
  std::error_code ignored;
  try {
    if (!std::filesystem::is_regular_file(path, ignored)) {
      tile.fault = "MISSING";
      return;
    }
    const std::string& sha256 = tile.record->sha256;
    if (!sha256.empty() && Sha256OfFile(path) != sha256) tile.fault = "NOT WHAT WAS CAPTURED";
    tile.picture = PictureOfFrame(ReadBayerFrame(path));
  } catch (const InputError&) {
    tile.fault = "CUT SHORT OR DAMAGED";
  }
}

std::string Caption(const Tile& tile) {
  std::string text;
  if (tile.record) text.append(std::to_string(tile.record->number)).append(" ");
  text += RoleName(tile.role);
  if (tile.role != FrameRole::kBlack) text.append(" ").append(Short(tile.wavelength_nm)).append(" nm");
  return text;
}

void Draw(Tile& tile, int x, int y, Plane<Rgb8>& canvas) {
  const bool good = tile.fault.empty();
  for (int row = y + 1; row < y + kTitleHeight + kTileHeight - 1; ++row)
    std::fill_n(canvas.Row(row) + x + 1, kTileWidth - 2, good ? kBackground : kBadColour);
  if (!tile.picture.empty())
    PasteScaled(tile.picture, x + 4, y + kTitleHeight, kTileWidth - 8, kTileHeight - 8, canvas);
  WriteText(canvas, x + 6, y + kTitleHeight - 7, Caption(tile), 0.45);
  if (!good) WriteText(canvas, x + 6, y + kTitleHeight + kTileHeight / 2, tile.fault, 0.5);
}

}  // namespace

SessionSheet DrawSessionSheet(const Session& session) {
  std::vector<Tile> tiles = TilesOf(session);
  ParallelFor(static_cast<int>(tiles.size()),
              [&](int i) { Look(session.directory, tiles[static_cast<std::size_t>(i)]); });
  // A role begins a new row.
  int row = 0, column = 0;
  std::vector<std::array<int, 2>> places;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const bool other_role = i > 0 && tiles[i].role != tiles[i - 1].role;
    if (column == kColumns || (other_role && column > 0)) {
      ++row;
      column = 0;
    }
    places.push_back({column * kTileWidth, row * (kTitleHeight + kTileHeight)});
    ++column;
  }
  SessionSheet sheet;
  sheet.picture = Plane<Rgb8>(kColumns * kTileWidth, (row + 1) * (kTitleHeight + kTileHeight), kBackground);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    Draw(tiles[i], places[i][0], places[i][1], sheet.picture);
    if (!tiles[i].fault.empty()) ++sheet.bad;
  }
  return sheet;
}

bool LacksFrames(const Session& session) {
  const std::vector<Tile> tiles = TilesOf(session);
  return std::any_of(tiles.begin(), tiles.end(), [](const Tile& tile) { return !tile.record; });
}

}  // namespace dermap
