// SPDX-License-Identifier: Apache-2.0
#include "transport/blur_monitor.h"

#include <algorithm>
#include <cmath>

#include "core/film.h"
#include "core/math.h"
#include "core/rng.h"
#include "transport/first_radius.h"

namespace brume {
namespace {

/// Two runs (groupOf): the radii of one alone hardly differ, but in the group that has the first
/// passes, and what then looks like blur may be one bright path.
constexpr std::int64_t kMinPassesOfGroup = 2 * std::int64_t{Film::kPassesPerSample};
constexpr double kBeyondDoubt = 5;  // standard errors
constexpr double kWorthIt = 0.9, kLeastFactor = 0.5;
constexpr double kLeastSpread = 1e-9;  // of squared radii, relative to their squares

/// Where `count` probes stand among `size` pixels; -1 elsewhere.
std::vector<int> spread(int size, int count) {
  std::vector<int> at(static_cast<std::size_t>(size), -1);
  for (int i = 0; i < count; ++i)
    at[static_cast<std::size_t>((2 * i + 1) * size / (2 * count))] = i;
  return at;
}

/// The group of a pass. Passes go in runs of those that complement each other in a pixel, dealt
/// anew each time, so that no group has a part of the pixel to itself.
std::size_t groupOf(std::int64_t pass) {
  constexpr auto kGroups = static_cast<std::int64_t>(BlurMonitor::kGroups);
  const std::int64_t run = pass / Film::kPassesPerSample;
  const auto shift = static_cast<std::int64_t>(hashIntegers(run / kGroups) % kGroups);
  return static_cast<std::size_t>((run + shift) % kGroups);
}

}  // namespace

double BlurMonitor::Estimate::radiusFactor() const {
  if (!standsOut(kBeyondDoubt)) return 1;
  const double x = std::pow(variance / (kNoiseOverBlur * blur2), 0.2);
  return x > kWorthIt ? 1 : std::max(x, kLeastFactor);
}

BlurMonitor::BlurMonitor(const Bounds2i& pixels)
    : pixels_(pixels),
      columns_(spread(pixels.width(), std::min(kProbesPerAxis, pixels.width()))),
      rows_(spread(pixels.height(), std::min(kProbesPerAxis, pixels.height()))),
      perRow_(std::min(kProbesPerAxis, pixels.width())) {
  probes_.resize(static_cast<std::size_t>(perRow_) *
                 static_cast<std::size_t>(std::min(kProbesPerAxis, pixels.height())));
}

std::optional<std::uint32_t> BlurMonitor::probeOf(Vec2i pixel) const {
  const int column = columns_[static_cast<std::size_t>(pixel.x - pixels_.lo.x)],
            row = rows_[static_cast<std::size_t>(pixel.y - pixels_.lo.y)];
  if (column < 0 || row < 0) return std::nullopt;
  return static_cast<std::uint32_t>(row * perRow_ + column);
}

void BlurMonitor::addPass(std::span<const ProbeLight> light, std::array<double, 2> radius2) {
  const std::size_t g = groupOf(passes_++);
  ++groups_[g].passes;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    groups_[g].radius2[kind] += radius2[kind];
    groups_[g].radius4[kind] += sqr(radius2[kind]);
  }
  for (std::size_t i = 0; i < probes_.size(); ++i) {
    Sums& sums = probes_[i].groups[g];
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      for (std::size_t kind = 0; kind < 2; ++kind) {
        const auto L = double{light[i].photons[kind][c]};
        sums.light[kind][channel] += L;
        sums.byRadius2[kind][channel] += radius2[kind] * L;
      }
      probes_[i].all[channel] += double{light[i].all[c]};
    }
  }
}

/// What a squared difference in a pixel counts, so that a mean over channels and pixels is
/// relative.
std::vector<double> BlurMonitor::weights() const {
  double mean = 0;
  for (const Probe& probe : probes_)
    for (double L : probe.all) mean += L / static_cast<double>(3 * probes_.size());
  std::vector<double> weights;
  weights.reserve(3 * probes_.size());
  const double scale = sqr(static_cast<double>(passes_)) / static_cast<double>(3 * probes_.size());
  for (const Probe& probe : probes_)
    for (double L : probe.all) {
      const double square = sqr(L) + kDarkShare * sqr(mean);
      weights.push_back(square > 0 ? scale / square : 0);
    }
  return weights;
}

std::optional<BlurMonitor::Estimate> BlurMonitor::estimate(Kind kind) const {
  double mean = 0;  // of s over all passes
  for (const Group& group : groups_) {
    if (group.passes < kMinPassesOfGroup) return std::nullopt;
    mean += group.radius2[kind] / static_cast<double>(passes_);
  }
  // b_g = sum_j slope_g (s_j - centre_g) L_j over a group's passes.
  std::array<double, kGroups> centre{}, slope{}, weightOf{};
  for (std::size_t g = 0; g < kGroups; ++g) {
    const Group& group = groups_[g];
    centre[g] = group.radius2[kind] / static_cast<double>(group.passes);
    const double spread = group.radius4[kind] - centre[g] * group.radius2[kind];
    if (!(spread > kLeastSpread * group.radius4[kind])) continue;
    slope[g] = mean / spread;
    weightOf[g] = spread / sqr(mean);
  }

  constexpr auto kCount = static_cast<double>(kGroups);
  const std::vector<double> relative = weights();
  std::array<std::array<double, kGroups>, kGroups> products{};
  Estimate found;
  for (std::size_t i = 0; i < probes_.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<double, kGroups> blur{}, light{};
      double all = 0;
      for (std::size_t g = 0; g < kGroups; ++g) {
        const Sums& sums = probes_[i].groups[g];
        blur[g] = slope[g] * (sums.byRadius2[kind][c] - centre[g] * sums.light[kind][c]);
        light[g] = sums.light[kind][c] / static_cast<double>(groups_[g].passes);
        all += light[g] / kCount;
      }
      const double w = relative[3 * i + c];
      for (std::size_t g = 0; g < kGroups; ++g) {
        found.variance += w * sqr(light[g] - all) / (kCount * (kCount - 1));
        for (std::size_t h = 0; h < g; ++h) products[g][h] += w * blur[g] * blur[h];
      }
    }
  double sum = 0, weight = 0, squares = 0;
  for (std::size_t g = 0; g < kGroups; ++g)
    for (std::size_t h = 0; h < g; ++h) {
      sum += weightOf[g] * weightOf[h] * products[g][h];
      weight += weightOf[g] * weightOf[h];
    }
  if (!(weight > 0)) return std::nullopt;
  found.blur2 = sum / weight;
  for (std::size_t g = 0; g < kGroups; ++g)
    for (std::size_t h = 0; h < g; ++h)
      squares += sqr(weightOf[g] * weightOf[h] * (products[g][h] - found.blur2));
  found.blur2Error = std::sqrt(squares) / weight;
  return found;
}

}  // namespace brume
