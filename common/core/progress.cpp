// SPDX-License-Identifier: Apache-2.0
// A progress bar with the time left.
#include "common/core/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace dermap {
namespace {

constexpr int kBarWidth = 30;
constexpr std::chrono::milliseconds kRedrawInterval{100};

}  // namespace

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)), on_terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputc('\n', stderr);
}

void ProgressBar::Update(double fraction) {
  if (!on_terminal_) return;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const auto now = Clock::now();
  if (drawn_ && fraction < 1.0 && now - last_draw_ < kRedrawInterval) return;
  last_draw_ = now;
  drawn_ = true;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const int filled = static_cast<int>(fraction * kBarWidth);
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  if (fraction > 0.0) {
    std::fprintf(stderr, "\r%-12s [%s] %3d %%  %.0f s left \x1b[K", label_.c_str(), bar.c_str(),
                 static_cast<int>(100 * fraction), elapsed_s * (1.0 - fraction) / fraction);
  } else {
    std::fprintf(stderr, "\r%-12s [%s]   0 %%\x1b[K", label_.c_str(), bar.c_str());
  }
  std::fflush(stderr);
}

}  // namespace dermap
