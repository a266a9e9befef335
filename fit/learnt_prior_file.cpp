// SPDX-License-Identifier: Apache-2.0
// The prior as JSON.
#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/json_table.h"
#include "fit/learnt_prior.h"

namespace dermap {
namespace {

constexpr const char* kFormat = "dermap prior";
constexpr int kVersion = 1;
constexpr double kRounding = 1e-9;  // of a matrix's largest entry, scaled by the ranges

double Range(int j) {
  return kParameters[j].upper - kParameters[j].lower;
}

nlohmann::ordered_json Named(const ParameterVector& values) {
  nlohmann::ordered_json json;
  for (int j = 0; j < kParameterCount; ++j) json[std::string(kParameters[j].name)] = values[j];
  return json;
}

nlohmann::ordered_json Named(const ParameterMatrix& matrix) {
  nlohmann::ordered_json json;
  for (int j = 0; j < kParameterCount; ++j) json[std::string(kParameters[j].name)] = matrix[j];
  return json;
}

TomlTable RequiredTable(TomlTable& file, const std::string& key) {
  std::optional<TomlTable> table = file.Table(key);
  if (!table)
    throw InputError(file.Where() + ": " + key +
                     " is missing; a prior has it; remedy: write the file anew with --save-prior");
  return std::move(*table);
}

ParameterVector ReadMean(TomlTable& file) {
  TomlTable table = RequiredTable(file, "mean");
  ParameterVector mean;
  for (int j = 0; j < kParameterCount; ++j)
    mean[j] =
        table.RequiredNumber(std::string(kParameters[j].name), kParameters[j].lower, kParameters[j].upper);
  table.Finish();
  return mean;
}

// Scaled by the ranges, so that one rounding suits all entries.
void CheckCovariance(const ParameterMatrix& matrix, const std::string& where) {
  Eigen::Matrix<double, kParameterCount, kParameterCount> scaled;
  for (int j = 0; j < kParameterCount; ++j)
    for (int k = 0; k < kParameterCount; ++k) scaled(j, k) = matrix[j][k] / (Range(j) * Range(k));
  const double rounding = kRounding * std::max(scaled.cwiseAbs().maxCoeff(), 1e-12);
  const std::string remedy = "; remedy: write the file anew with --save-prior";
  if ((scaled - scaled.transpose()).cwiseAbs().maxCoeff() > rounding)
    throw InputError(where + " is not symmetric, but a covariance is" + remedy);
  const Eigen::SelfAdjointEigenSolver<decltype(scaled)> solver(scaled, Eigen::EigenvaluesOnly);
  if (!(solver.eigenvalues()[0] >= -rounding))
    throw InputError(where + " is not positive definite (its smallest eigenvalue, scaled by the ranges, is " +
                     std::to_string(solver.eigenvalues()[0]) + "), but a covariance is" + remedy);
}

ParameterMatrix ReadMatrix(TomlTable& file, const std::string& key) {
  TomlTable table = RequiredTable(file, key);
  ParameterMatrix matrix;
  for (int j = 0; j < kParameterCount; ++j) {
    const std::string name(kParameters[j].name);
    const std::vector<double> row = table.Numbers(name, {});
    if (row.size() != kParameterCount)
      throw InputError(table.Where(name) + ": " + key + "." + name + " has " + std::to_string(row.size()) +
                       " numbers, but needs one for each of C_m, beta_m, C_he, C_bc, C_hd");
    std::copy(row.begin(), row.end(), matrix[j].begin());
  }
  table.Finish();
  CheckCovariance(matrix, file.Where() + ": " + key);
  return matrix;
}

}  // namespace

LearntPrior ReadLearntPrior(const std::filesystem::path& path) {
  TomlTable file = ReadJsonTable(path);
  if (file.String("format", "") != kFormat)
    throw InputError(path.string() + " is not a prior (its format is not \"" + kFormat +
                     "\"); remedy: a file that dermap fit --save-prior wrote");
  const int version = file.RequiredInteger("format_version", 0, 1000000);
  if (version != kVersion)
    throw InputError(path.string() + " has version " + std::to_string(version) +
                     " of the prior's format, but this program knows version " + std::to_string(kVersion) +
                     "; remedy: write it anew with --save-prior");
  LearntPrior prior;
  const int fits = file.RequiredInteger("fits", 1, 1000000);
  for (TomlTable& source : file.Tables("sources")) {
    prior.sources.push_back({source.RequiredString("name"), source.RequiredString("sha256")});
    source.Finish();
  }
  if (prior.fits() != fits)
    throw InputError(path.string() + " counts " + std::to_string(fits) + " fits, but lists " +
                     std::to_string(prior.fits()) + " in sources; remedy: write it anew with --save-prior");
  prior.mean = ReadMean(file);
  prior.covariance = ReadMatrix(file, "covariance");
  prior.detail_covariance = ReadMatrix(file, "detail_covariance");
  file.Finish();
  return prior;
}

void WriteLearntPrior(const std::filesystem::path& path, const LearntPrior& prior) {
  nlohmann::ordered_json json;
  json["format"] = kFormat;
  json["format_version"] = kVersion;
  json["fits"] = prior.fits();
  json["mean"] = Named(prior.mean);
  json["covariance"] = Named(prior.covariance);
  json["detail_covariance"] = Named(prior.detail_covariance);
  json["sources"] = nlohmann::ordered_json::array();
  for (const PriorSource& source : prior.sources)
    json["sources"].push_back({{"name", source.name}, {"sha256", source.sha256}});
  WriteFileAtomically(path,
                      json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace dermap
