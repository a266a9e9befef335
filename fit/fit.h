// SPDX-License-Identifier: Apache-2.0
// The fit: a reflectance stack in, maps of skin's chromophores with error bars out.
#pragma once

#include "common/core/progress.h"
#include "common/files/stack.h"
#include "common/tissue/tissue.h"
#include "fit/fit_result.h"
#include "fit/options.h"

namespace dermap {

// Throws InputError for a stack or options that cannot be fitted. Not converging is a result.
FitResult FitStack(const ReflectanceStack& stack, const FitOptions& options, const Chromophores& chromophores,
                   const ProgressFunction& progress = {});

}  // namespace dermap
