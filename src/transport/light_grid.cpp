// SPDX-License-Identifier: Apache-2.0
#include "transport/light_grid.h"

#include "core/parallel.h"

namespace brume {
namespace {

constexpr int kMaxCellsPerAxis = 16;
/// Bound on cells times lights: 4 MiB of probabilities, built in well under a tenth of a second.
constexpr std::size_t kMaxEntries = std::size_t{1} << 20;
/// Share of the uniform part of the mixture.
constexpr double kUniformShare = 0.1;
/// Stands for an importance that is not finite (a light inside the cell).
constexpr double kHugeImportance = 1e30;

}  // namespace

std::vector<const Light*> emittingLights(const Scene& scene) {
  std::vector<const Light*> result;
  for (const auto& light : scene.lights())
    if (!light->power().isBlack()) result.push_back(light.get());
  return result;
}

LightGrid::LightGrid(const Scene& scene) : lights_(emittingLights(scene)) {
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    indexOf_.emplace_back(lights_[i], i);
    hasHittable_ = hasHittable_ || !lights_[i]->isDelta();
  }
  std::sort(indexOf_.begin(), indexOf_.end());
  if (lights_.size() < 2) return;

  // Cells are about cubic; fewer of them when there are many lights.
  const Bounds3& bounds = scene.bounds();
  const Vec3 extent = bounds.isEmpty() ? Vec3(0) : bounds.diagonal();
  const float longest = maxComponent(extent);
  std::size_t cells = 1;
  for (int perAxis = kMaxCellsPerAxis; perAxis >= 1; perAxis /= 2) {
    cells = 1;
    for (int a = 0; a < 3; ++a) {
      const float share = longest > 0 ? extent[a] / longest : 0.f;
      n_[a] = std::max(1, static_cast<int>(std::lround(share * static_cast<float>(perAxis))));
      cells *= static_cast<std::size_t>(n_[a]);
    }
    if (cells * lights_.size() <= kMaxEntries) break;
  }
  if (!bounds.isEmpty()) lo_ = bounds.lo;
  for (int a = 0; a < 3; ++a)
    cellsPerLength_[a] = extent[a] > 0 ? static_cast<float>(n_[a]) / extent[a] : 0.f;

  cdf_.resize(cells * lights_.size());
  const Vec3 size{extent.x / static_cast<float>(n_[0]), extent.y / static_cast<float>(n_[1]),
                  extent.z / static_cast<float>(n_[2])};
  // A point on a border may round into the neighbour: cells overlap a little.
  const Vec3 margin = size * 1e-3f;
  forEachChunk(static_cast<std::int64_t>(cells), 64,
               [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                 for (std::int64_t c = begin; c < end; ++c) {
                   const Vec3 corner(c % n_[0], c / n_[0] % n_[1], c / n_[0] / n_[1]);
                   const Vec3 lo = lo_ + corner * size;
                   fillCell({lo - margin, lo + size + margin},
                            &cdf_[static_cast<std::size_t>(c) * lights_.size()]);
                 }
               });
}

void LightGrid::fillCell(const Bounds3& cell, float* cdf) const {
  std::vector<double> importance(lights_.size());
  double sum = 0;
  std::size_t reaching = 0;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const double value = lights_[i]->importance(cell);
    importance[i] = value < kHugeImportance ? std::max(0.0, value) : kHugeImportance;
    sum += importance[i];
    if (importance[i] > 0) ++reaching;
  }
  double below = 0;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (importance[i] > 0)
      below +=
          (1 - kUniformShare) * importance[i] / sum + kUniformShare / static_cast<double>(reaching);
    cdf[i] = static_cast<float>(below);
  }
  // The last light that can be chosen takes what rounding left; so do the entries behind it.
  if (reaching == 0) return;
  for (std::size_t i = lights_.size(); i-- > 0;) {
    cdf[i] = 1.f;
    if (importance[i] > 0) break;
  }
}

std::size_t LightGrid::cellOf(const Vec3& p) const {
  std::size_t index = 0;
  for (int a = 2; a >= 0; --a) {
    const float x = (p[a] - lo_[a]) * cellsPerLength_[a];
    const int i = x > 0 ? static_cast<int>(std::min(x, static_cast<float>(n_[a] - 1))) : 0;
    index = index * static_cast<std::size_t>(n_[a]) + static_cast<std::size_t>(i);
  }
  return index;
}

std::optional<LightGrid::Choice> LightGrid::choose(const Vec3& p, float u) const {
  if (lights_.empty()) return std::nullopt;
  if (lights_.size() == 1) return Choice{lights_[0], 1.f};
  const float* cdf = &cdf_[cellOf(p) * lights_.size()];
  const float* end = cdf + lights_.size();
  const float* found = std::upper_bound(cdf, end, u);
  if (found == end) return std::nullopt;
  return Choice{lights_[static_cast<std::size_t>(found - cdf)],
                found == cdf ? *found : *found - *(found - 1)};
}

float LightGrid::probability(const Vec3& p, const Light* light) const {
  const auto it = std::lower_bound(indexOf_.begin(), indexOf_.end(), std::pair{light, 0ul});
  if (it == indexOf_.end() || it->first != light) return 0.f;
  if (lights_.size() == 1) return 1.f;
  const float* cdf = &cdf_[cellOf(p) * lights_.size()];
  const std::size_t i = it->second;
  return i == 0 ? cdf[0] : cdf[i] - cdf[i - 1];
}

}  // namespace brume
