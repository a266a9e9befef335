// SPDX-License-Identifier: Apache-2.0
// Names on command lines and in files.
#include <string>

#include "common/core/error.h"
#include "common/transport/forward_model.h"

namespace dermap {

std::string_view RungName(Rung rung) {
  switch (rung) {
    case Rung::kLocal:
      return "local";
    case Rung::kHomogeneous:
      return "homogeneous";
    case Rung::kFirstOrder:
      return "first-order";
    case Rung::kFull:
      return "full";
  }
  return "";
}

std::string_view EngineName(Engine engine) {
  switch (engine) {
    case Engine::kCascade:
      return "cascade";
    case Engine::kPyramid:
      return "pyramid";
    case Engine::kLowRank:
      return "lowrank";
  }
  return "";
}

Engine EngineFromName(std::string_view name) {
  for (const Engine engine : {Engine::kLowRank, Engine::kPyramid, Engine::kCascade}) {
    if (name == EngineName(engine)) return engine;
  }
  throw InputError("there is no engine '" + std::string(name) + "'; known are: lowrank, pyramid, cascade");
}

std::string_view NameOf(BeneathTape beneath) {
  switch (beneath) {
    case BeneathTape::kEdge:
      return "edge";
    case BeneathTape::kMirrored:
      return "mirrored";
    case BeneathTape::kMean:
      return "mean";
  }
  return "";
}

BeneathTape BeneathTapeFromName(std::string_view name) {
  for (const BeneathTape beneath : {BeneathTape::kEdge, BeneathTape::kMirrored, BeneathTape::kMean})
    if (name == NameOf(beneath)) return beneath;
  throw InputError("skin beneath the tape cannot be '" + std::string(name) +
                   "'; known are: edge, mirrored, mean");
}

}  // namespace dermap
