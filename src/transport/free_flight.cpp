// SPDX-License-Identifier: Apache-2.0
#include "transport/free_flight.h"

#include <algorithm>
#include <bit>

#include "core/lanes_math.h"

namespace brume {

Rgb albedoOf(const MediumCoefficients& c) {
  const Rgb t = c.sigma_t();
  return {t.r > 0 ? c.sigma_s.r / t.r : 0, t.g > 0 ? c.sigma_s.g / t.g : 0,
          t.b > 0 ? c.sigma_s.b / t.b : 0};
}

Rgb flightChannels(const Rgb& power) {
  const Rgb share(std::abs(power.r), std::abs(power.g), std::abs(power.b));
  return share / (share.r + share.g + share.b);
}

namespace {

/// All channels are alike: then the density is the pdf.
bool isGrey(const Rgb& c) { return c.r == c.g && c.g == c.b; }

/// The channel that draws, and the optical depth to which it flies.
struct DrawnDepth {
  int channel = 0;
  double depth;

  DrawnDepth(const Rgb& channels, float uChannel, float uDepth)
      : channel(uChannel < channels.r                                   ? 0
                : uChannel < channels.r + channels.g || channels.b == 0 ? 1
                                                                        : 2) {
    // What chose the channel refines the depth as well: 24 bits alone would draw depths below 1e-6
    // by the wrong probability.
    const double before = channel == 0   ? 0
                          : channel == 1 ? double{channels.r}
                                         : double{channels.r} + double{channels.g};
    setDepth(std::clamp((double{uChannel} - before) / double{channels[channel]}, 0.0,
                        double{kOneMinusEpsilon}),
             uDepth);
  }
  /// Where all channels are alike.
  DrawnDepth(float uChannel, float uDepth) { setDepth(double{uChannel}, uDepth); }

 private:
  /// The argument of the logarithm is exact to 2^-53, and the depth is no less than 2^-48.
  void setDepth(double rest, float uDepth) {
    depth = -std::log(1 - (double{uDepth} + rest * 0x1p-24));
  }
};

/// density / pdf by the balance heuristic; `density` is sigma_t Tr at a collision, Tr behind.
Rgb flightWeight(const Rgb& density, const Rgb& channels) {
  const Rgb drawn = channels * density;
  const float pdf = drawn.r + drawn.g + drawn.b;
  return pdf > 0 ? density / pdf : Rgb();
}

}  // namespace

FreeFlight sampleFreeFlight(const MediumAlongRay& medium, const Rgb& channels, float uChannel,
                            float uDepth) {
  const DrawnDepth drawn(channels, uChannel, uDepth);
  FreeFlight flight;
  const auto t = medium.invert(drawn.channel, drawn.depth);
  if (t) flight.t = static_cast<float>(*t);
  flight.weight = flightWeight(
      t ? medium.at(*flight.t).sigma_t() * medium.transmittance(*t) : medium.transmittance(),
      channels);
  return flight;
}

FreeFlight sampleFreeFlight(const Volume& volume, const Ray& ray, Interval range,
                            const Rgb& channels, float uChannel, float uDepth) {
  const Rgb sigma_t = volume.proportions()->sigma_t();
  if (isGrey(sigma_t)) {
    const auto depth = static_cast<float>(DrawnDepth(uChannel, uDepth).depth);
    return {volume.invertOpticalDepth(ray, range, 0, depth)};
  }
  const DrawnDepth drawn(channels, uChannel, uDepth);
  const auto depth = static_cast<float>(drawn.depth);
  FreeFlight flight{volume.invertOpticalDepth(ray, range, drawn.channel, depth)};
  // The other channels' depths are in proportion.
  const Rgb density = flight.t ? sigma_t * exp(sigma_t * (-depth / sigma_t[drawn.channel]))
                               : volume.transmittance(ray, range);
  flight.weight = flightWeight(density, channels);
  return flight;
}

namespace {

#define BRUME_KERNELS "transport/free_flight.inl"
#include "core/both_lanes.inl"

}  // namespace

std::optional<UniformFlights> UniformFlights::through(const Volume& volume) {
  const auto medium = volume.uniform();
  std::vector<MediumBox> boxes;
  volume.appendBoxes(boxes);
  if (!medium || boxes.size() != 1) return std::nullopt;
  return UniformFlights(*medium, boxes.front());
}

UniformFlights::UniformFlights(const UniformMedium& medium, const MediumBox& box)
    : medium_(medium) {
  box_.sigma_t = medium.coefficients.sigma_t();
  box_.excess = box_.sigma_t - Rgb(box_.sigma_t.minChannel());
  box_.isGrey = isGrey(box_.sigma_t);
  for (int c = 0; c < 3; ++c)
    box_.perSigma[c] = box_.sigma_t[c] > 0 ? 1 / double{box_.sigma_t[c]} : double{kInfinity};
  for (std::size_t a = 0; a < 3; ++a) {
    box_.axes[a] = box.normal[2 * a + 1];
    box_.lo[a] = -box.offset[2 * a];
    box_.hi[a] = box.offset[2 * a + 1];
  }
}

void UniformFlights::sample(PathWave& wave) const {
  hasAvx2() ? avx2::fly(box_, wave) : generic::fly(box_, wave);
}

void UniformFlights::weighCollisions(PathWave& wave) const {
  if (box_.isGrey) return;
  hasAvx2() ? avx2::weighCollisions(box_, wave) : generic::weighCollisions(box_, wave);
}

Rgb UniformFlights::weightAt(float t, const PathWave& wave, std::size_t path) const {
  const float way = std::min(t, wave.mediaTo[path]) - wave.mediaFrom[path];
  if (box_.isGrey || !(way > 0)) return Rgb(1);
  // Transmittance over that of the least channel: weights need no more, and it does not vanish.
  return flightWeight(exp(-box_.excess * way), wave.channels[path]);
}

}  // namespace brume
