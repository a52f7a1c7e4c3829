// SPDX-License-Identifier: Apache-2.0
#include "volumes/density_grid.h"

namespace brume {

namespace {

double mix(double a, double b, double f) { return (1 - f) * a + f * b; }

std::size_t product(const DensityGrid::Cell& size) {
  return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
         static_cast<std::size_t>(size[2]);
}

/// Blocks of 8 that cover n units.
std::int32_t blocks(std::int32_t n) { return n / 8 + (n % 8 != 0); }

}  // namespace

DensityGrid::DensityGrid(std::vector<float> voxels, const Cell& size)
    : voxels_(std::move(voxels)), size_(size) {
  // Pairs along x end in the grid, unless an axis of one voxel has none.
  if (size_[0] == 1) {
    voxels_.reserve(voxels_.size() + 1);  // not twice as many
    voxels_.push_back(0);
  }
  buildFirstLevel();
  while (buildNextLevel()) {
  }
  for (const float m : levels_.back().max) maxDensity_ = std::max(maxDensity_, m);
}

std::size_t DensityGrid::overheadBytes() const {
  std::size_t bytes = sizeof(*this);
  for (const Level& l : levels_) bytes += l.max.capacity() * sizeof(float);
  return bytes;
}

void DensityGrid::buildFirstLevel() {
  // A voxel v lies on the edge of cells v and v + 1: it counts for the blocks of both.
  Level level;
  for (int a = 0; a < 3; ++a) level.size[a] = size_[a] / 8 + 1;
  level.max.assign(product(level.size), 0.f);
  const std::size_t strideY = level.size[0];
  const std::size_t strideZ = strideY * static_cast<std::size_t>(level.size[1]);

  // First the maxima of rows over blocks in x, then each row into at most four rows of blocks.
  std::vector<float> row(strideY);
  const float* voxel = voxels_.data();
  for (std::int32_t z = 0; z < size_[2]; ++z)
    for (std::int32_t y = 0; y < size_[1]; ++y, voxel += size_[0]) {
      for (std::size_t b = 0; b < strideY; ++b) {
        const std::int32_t begin = std::max<std::int32_t>(0, static_cast<std::int32_t>(b) * 8 - 1);
        const std::int32_t end =
            static_cast<std::int32_t>(std::min<std::int64_t>(size_[0], std::int64_t(b) * 8 + 8));
        float m = 0;
        for (std::int32_t x = begin; x < end; ++x) m = std::max(m, voxel[x]);
        row[b] = m;
      }
      for (std::int32_t bz = z / 8; bz <= (z + 1) / 8; ++bz)
        for (std::int32_t by = y / 8; by <= (y + 1) / 8; ++by) {
          float* target = level.max.data() + bz * strideZ + by * strideY;
          for (std::size_t b = 0; b < strideY; ++b) target[b] = std::max(target[b], row[b]);
        }
    }
  levels_.push_back(std::move(level));
}

bool DensityGrid::buildNextLevel() {
  const Level& fine = levels_.back();
  if (std::max({fine.size[0], fine.size[1], fine.size[2]}) <= 8) return false;
  Level coarse;
  for (int a = 0; a < 3; ++a) coarse.size[a] = blocks(fine.size[a]);
  coarse.max.assign(product(coarse.size), 0.f);
  std::size_t i = 0;
  for (std::int32_t z = 0; z < fine.size[2]; ++z)
    for (std::int32_t y = 0; y < fine.size[1]; ++y)
      for (std::int32_t x = 0; x < fine.size[0]; ++x, ++i) {
        float& m =
            coarse.max[(static_cast<std::size_t>(z / 8) * coarse.size[1] + y / 8) * coarse.size[0] +
                       x / 8];
        m = std::max(m, fine.max[i]);
      }
  levels_.push_back(std::move(coarse));
  return true;
}

double DensityGrid::density(const Vec3d& w) const {
  Cell cell;
  Vec3d f;
  for (int a = 0; a < 3; ++a) {
    const double index = std::clamp(std::floor(w[a]), 0.0, double(size_[a]));
    cell[a] = static_cast<std::int32_t>(index);
    f[a] = std::clamp(w[a] - index, 0.0, 1.0);
  }
  return CellCorners(*this, cell).at(f);
}

DensityGrid::Sampler::Sampler(const DensityGrid& grid) {
  const auto rowLength = static_cast<std::size_t>(grid.size_[0]);
  const std::size_t count = product(grid.size_);
  rowsUpTo_.reserve(count / rowLength);
  double sum = 0;
  for (std::size_t begin = 0; begin < count; begin += rowLength) {
    for (std::size_t i = 0; i < rowLength; ++i) sum += double{grid.voxels_[begin + i]};
    rowsUpTo_.push_back(sum);
  }
}

Vec3d DensityGrid::Sampler::sample(const DensityGrid& grid, Rng& rng) const {
  // A row, then a voxel in it: the last one that is not empty where rounding left something.
  const double target = rng.uniformDouble() * total();
  const auto row = static_cast<std::size_t>(
      std::upper_bound(rowsUpTo_.begin(), rowsUpTo_.end() - 1, target) - rowsUpTo_.begin());
  const Cell& n = grid.size_;
  const float* voxels = grid.voxels_.data() + row * static_cast<std::size_t>(n[0]);
  double rest = target - (row == 0 ? 0 : rowsUpTo_[row - 1]);
  std::int32_t x = 0;
  for (std::int32_t i = 0; i < n[0]; ++i) {
    if (voxels[i] == 0) continue;
    x = i;
    rest -= double{voxels[i]};
    if (rest < 0) break;
  }

  const auto rowIndex = static_cast<std::int32_t>(row);
  const Cell voxel{x, rowIndex % n[1], rowIndex / n[1]};
  Vec3d w;
  for (int a = 0; a < 3; ++a) {
    // The sum of two uniform numbers has a tent for its density; where the voxel lies at a border,
    // its outer half is spread evenly over half a voxel.
    const double offset = rng.uniformDouble() + rng.uniformDouble();
    w[a] = voxel[a] + offset;
    if (voxel[a] == 0 && offset < 1) w[a] = 0.5 + 0.5 * offset * offset;
    if (voxel[a] == n[a] - 1 && offset >= 1) w[a] = n[a] + 0.5 - 0.5 * sqr(2 - offset);
  }
  return w;
}

DensityGrid::CellCorners::CellCorners(const DensityGrid& grid, const Cell& cell) {
  const Cell& n = grid.size_;
  std::size_t index[3][2];
  const std::size_t stride[3] = {1, static_cast<std::size_t>(n[0]),
                                 static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1])};
  for (int a = 0; a < 3; ++a) {
    index[a][0] = static_cast<std::size_t>(std::max(cell[a] - 1, 0)) * stride[a];
    index[a][1] = static_cast<std::size_t>(std::min(cell[a], n[a] - 1)) * stride[a];
  }
  const float* voxels = grid.voxels_.data();
  for (int i = 0; i < 8; ++i)
    v_[i] = double{voxels[index[0][i & 1] + index[1][(i >> 1) & 1] + index[2][i >> 2]]};
}

double DensityGrid::CellCorners::at(const Vec3d& f) const {
  const double y0 = mix(mix(v_[0], v_[1], f.x), mix(v_[2], v_[3], f.x), f.y);
  const double y1 = mix(mix(v_[4], v_[5], f.x), mix(v_[6], v_[7], f.x), f.y);
  return mix(y0, y1, f.z);
}

std::array<double, 4> DensityGrid::CellCorners::bernstein(const Vec3d& p, const Vec3d& q) const {
  // Restrict to the box with corners p and q, one axis after another; bit set: q.
  double b[8];
  for (int i = 0; i < 8; ++i) b[i] = mix(v_[i & 6], v_[i | 1], i & 1 ? q.x : p.x);
  double c[8];
  for (int i = 0; i < 8; ++i) c[i] = mix(b[i & 5], b[i | 2], i & 2 ? q.y : p.y);
  for (int i = 0; i < 8; ++i) b[i] = mix(c[i & 3], c[i | 4], i & 4 ? q.z : p.z);
  return {b[0], (b[1] + b[2] + b[4]) / 3, (b[3] + b[5] + b[6]) / 3, b[7]};
}

}  // namespace brume
