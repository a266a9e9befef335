// SPDX-License-Identifier: Apache-2.0
// The commands, one function (and one file) each. argv[0] is the command's own name.
#pragma once

namespace dermap {

int RunCaptureCommand(int argc, char** argv);
int RunDevicesCommand(int argc, char** argv);
int RunServeCommand(int argc, char** argv);
int RunVerifyCommand(int argc, char** argv);
int RunCalibrateCommand(int argc, char** argv);
int RunFitCommand(int argc, char** argv);
// Whether `fit` is asked for spectra rather than maps: a .csv among its words, or --spectra.
bool MeansSpectra(int argc, char** argv);
int RunFitSpectraCommand(int argc, char** argv);
int RunRenderCommand(int argc, char** argv);
int RunImportCommand(int argc, char** argv);
int RunOpticsCommand(int argc, char** argv);
int RunStudyCommand(int argc, char** argv);
int RunCalibrationStudyCommand(int argc, char** argv);

}  // namespace dermap
