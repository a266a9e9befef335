// SPDX-License-Identifier: Apache-2.0
// A session as an 8-megapixel camera makes it: 10 bands, a Spectralon and a skin frame for each, 11 black
// frames, uncompressed (DNG) and in lossless JPEG (CR2). Tells the time of each stage, the memory's peak, and
// what decoding one frame takes. The frames are simulated once, in a process of their own, so that their
// memory is not counted.
#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/optical_bench.h"
#include "calibrate/calibrate.h"
#include "calibrate/raw_frame.h"
#include "common/core/parallel.h"
#include "common/files/atomic_file.h"
#include "common/files/session.h"
#include "tests/calibrate/camera_files.h"

namespace dermap {
namespace {

constexpr int kWidth = 3504, kHeight = 2336;  // of an EOS 20D [D08 6.1]
constexpr int kBands = 10;
constexpr int kBlacks = 11;
constexpr int kIso = 125;

enum class Kind { kDng, kCr2 };

const char* SuffixOf(Kind kind) {
  return kind == Kind::kDng ? ".dng" : ".cr2";
}

std::filesystem::path FolderOf(Kind kind) {
  return std::filesystem::temp_directory_path() / (std::string("dermap_calibrate_bench") + SuffixOf(kind));
}

// Nine filters of the same colour as 540 nm and that one: what a band's colour is does not matter to the
// time.
Session MakeSession(Kind kind) {
  Session session;
  session.directory = FolderOf(kind);
  session.rig = ReadRig(ConfigDirectory() / "rigs/simulated_8band.toml");
  session.rig.optics.camera_csv.clear();  // else the filters' order would be found to be wrong
  session.rig.slots.clear();
  for (int b = 0; b < kBands; ++b) {
    session.rig.slots.push_back({b + 1, 500.0 + 10.0 * b, 10.0, false});
    session.plan.exposures.push_back({b + 1, 10.0, kIso});
  }
  session.rig.slots.push_back({kBands + 1, 0.0, 0.0, true});
  session.complete = true;
  const auto add = [&](FrameRole role, const WheelSlot& slot) {
    FrameRecord frame;
    frame.number = static_cast<int>(session.frames.size()) + 1;
    frame.role = role;
    frame.slot = slot.slot;
    frame.wavelength_nm = slot.wavelength_nm;
    frame.fwhm_nm = slot.fwhm_nm;
    frame.exposure_ms = 10.0;
    frame.iso = kIso;
    frame.file = FrameFileName(frame, SuffixOf(kind));
    session.frames.push_back(frame);
  };
  for (int i = 0; i < kBlacks; ++i) add(FrameRole::kBlack, session.rig.slots.back());
  for (int b = 0; b < kBands; ++b) add(FrameRole::kSpectralon, session.rig.slots[b]);
  for (int b = 0; b < kBands; ++b) add(FrameRole::kSkin, session.rig.slots[b]);
  return session;
}

std::vector<std::byte> Encode(const Plane<std::uint16_t>& photosites, Kind kind) {
  DngMetadata metadata;
  metadata.iso = kIso;
  if (kind == Kind::kDng) return EncodeDng(photosites, metadata);
  return EncodeCr2(photosites, {"Canon", "Canon EOS 9999D", 12}, kWidth / 3);
}

// One frame of each role, copied to every place: noise and pose repeat, which the time does not notice.
void WriteSimulatedSession(Session session, Kind kind) {
  Scene scene = ReadScene(ConfigDirectory() / "scenes/checker.toml", session.rig.window_mm);
  BenchConfig& bench = scene.bench;
  bench.width_px = kWidth;
  bench.height_px = kHeight;
  bench.window_center_px = {1400.0, 1165.0};
  bench.scale_px_per_mm = 150.0;
  bench.camera_distance_mm = 400.0;
  bench.psf_sigma_px = 0.8;
  const OpticalBench optical(session.rig, scene);
  std::array<std::vector<std::byte>, 3> encoded;
  for (FrameRecord& frame : session.frames) {
    auto& bytes = encoded[static_cast<std::size_t>(frame.role)];
    if (bytes.empty()) {
      const Shot shot{frame.role, frame.slot, frame.exposure_ms, frame.iso, frame.number};
      bytes = Encode(optical.Expose(shot), kind);
    }
    WriteFileAtomically(session.directory / frame.file, bytes);
    frame.sha256 = Sha256OfFile(session.directory / frame.file);
  }
  WriteSession(session);
}

Session BenchSession(Kind kind) {
  if (!std::filesystem::exists(FolderOf(kind) / "session.json")) {
    std::fprintf(stderr, "simulating %d frames of %dx%d (%s), once ...\n", kBlacks + 2 * kBands, kWidth,
                 kHeight, SuffixOf(kind));
    const pid_t child = fork();
    if (child == 0) {
      WriteSimulatedSession(MakeSession(kind), kind);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
  }
  return ReadSession(FolderOf(kind));
}

// Of all threads; a shared machine changes it less than the time by the clock.
double ProcessorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// The peak of the memory in use counts from here (Linux: proc(5)).
void ForgetPeak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

double Peak_MB() {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    double kilobytes = 0.0;
    if (key == "VmHWM:" && status >> kilobytes) return kilobytes / 1024.0;
  }
  return 0.0;
}

void CalibrateEightMegapixels(benchmark::State& state, Kind kind) {
  const Session session = BenchSession(kind);
  const ThreadLimit threads(static_cast<int>(state.range(0)));
  std::vector<StageSeconds> stages;
  ForgetPeak();
  const double before = ProcessorSeconds();
  for (auto _ : state) {
    const CalibrationResult result = CalibrateSession(session, {});
    benchmark::DoNotOptimize(result.stack.reflectance[0].data());
    stages = result.seconds;
  }
  for (const StageSeconds& stage : stages) state.counters[stage.stage + "_s"] = stage.seconds;
  state.counters["cpu_s"] = (ProcessorSeconds() - before) / static_cast<double>(state.iterations());
  state.counters["peak_MB"] = Peak_MB();
}
BENCHMARK_CAPTURE(CalibrateEightMegapixels, dng, Kind::kDng)
    ->Arg(2)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->Iterations(1);
BENCHMARK_CAPTURE(CalibrateEightMegapixels, cr2, Kind::kCr2)
    ->Arg(2)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->Iterations(1);

void DecodeFrame(benchmark::State& state, Kind kind) {
  const Session session = BenchSession(kind);
  const FrameRecord& skin = session.frames.back();
  for (auto _ : state) benchmark::DoNotOptimize(ReadBayerFrame(session.directory / skin.file).values.data());
  state.counters["photosites"] =
      benchmark::Counter(double(kWidth) * kHeight, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(DecodeFrame, dng, Kind::kDng)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(DecodeFrame, cr2, Kind::kCr2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dermap

BENCHMARK_MAIN();
