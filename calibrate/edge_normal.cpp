// SPDX-License-Identifier: Apache-2.0
// Schur complements of the stretches' blocks.
#include "calibrate/edge_normal.h"

#include <Eigen/Dense>

namespace dermap {
namespace {

constexpr int kShared = EdgeNormal::kShared;
constexpr int kOwn = EdgeNormal::kOwn;
constexpr double kRidge = 1e-9;  // of the diagonal, against rounding
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;
using SharedVector = Eigen::Matrix<double, kShared, 1>;
using OwnMatrix = Eigen::Matrix<double, kOwn, kOwn>;
using OwnVector = Eigen::Matrix<double, kOwn, 1>;
using CrossMatrix = Eigen::Matrix<double, kOwn, kShared>;

template <class Matrix, class Rows>
Matrix FromLower(const Rows& rows) {
  Matrix m;
  for (int i = 0; i < m.rows(); ++i) {
    for (int j = 0; j <= i; ++j) m(i, j) = m(j, i) = rows[i][j] * (i == j ? 1.0 + kRidge : 1.0);
  }
  return m;
}

struct Block {
  Eigen::LDLT<OwnMatrix> own;
  CrossMatrix cross;
  OwnVector right;
};

Block BlockOf(const EdgeNormal::Stretch& stretch) {
  Block block{Eigen::LDLT<OwnMatrix>(FromLower<OwnMatrix>(stretch.own)), {}, {}};
  for (int i = 0; i < kOwn; ++i) {
    for (int j = 0; j < kShared; ++j) block.cross(i, j) = stretch.cross[i][j];
    block.right(i) = stretch.right[i];
  }
  return block;
}

SharedMatrix Reduced(const EdgeNormal& normal, const std::vector<Block>& blocks) {
  SharedMatrix reduced = FromLower<SharedMatrix>(normal.shared);
  for (const Block& b : blocks) reduced -= b.cross.transpose() * b.own.solve(b.cross);
  return reduced;
}

std::vector<Block> BlocksOf(const EdgeNormal& normal) {
  std::vector<Block> blocks;
  for (const EdgeNormal::Stretch& stretch : normal.stretches) blocks.push_back(BlockOf(stretch));
  return blocks;
}

}  // namespace

EdgeStep Solve(const EdgeNormal& normal) {
  const std::vector<Block> blocks = BlocksOf(normal);
  SharedVector right = SharedVector::Map(normal.right.data());
  for (const Block& b : blocks) right -= b.cross.transpose() * b.own.solve(b.right);
  const SharedVector shared = Reduced(normal, blocks).ldlt().solve(right);
  EdgeStep step;
  SharedVector::Map(step.shared.data()) = shared;
  for (const Block& b : blocks) {
    const OwnVector own = b.own.solve(b.right - b.cross * shared);
    step.own.emplace_back();
    OwnVector::Map(step.own.back().data()) = own;
  }
  return step;
}

double VarianceAlong(const EdgeNormal& normal, const EdgeNormal::Shared& direction) {
  const SharedVector along = SharedVector::Map(direction.data());
  return along.dot(Reduced(normal, BlocksOf(normal)).ldlt().solve(along));
}

}  // namespace dermap
