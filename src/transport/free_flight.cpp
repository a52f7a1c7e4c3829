// SPDX-License-Identifier: Apache-2.0
#include "transport/free_flight.h"

#include <algorithm>

#include "core/rng.h"

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

/// The channel that draws, and the optical depth to which it flies.
struct DrawnDepth {
  int channel;
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
    const double rest = std::clamp((double{uChannel} - before) / double{channels[channel]}, 0.0,
                                   double{kOneMinusEpsilon});
    depth = -std::log1p(-(double{uDepth} + rest * 0x1p-24));
  }
};

/// All channels are alike: then the density is the pdf.
bool isGrey(const Rgb& c) { return c.r == c.g && c.g == c.b; }

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
  flight.t = medium.invert(drawn.channel, drawn.depth);
  flight.weight =
      flightWeight(flight.t ? medium.at(*flight.t).sigma_t() * medium.transmittance(*flight.t)
                            : medium.transmittance(),
                   channels);
  return flight;
}

FreeFlight sampleFreeFlight(const UniformMedium& medium, Interval range, const Rgb& channels,
                            float uChannel, float uDepth) {
  const DrawnDepth drawn(channels, uChannel, uDepth);
  const Rgb sigma_t = medium.coefficients.sigma_t();
  const double way = double{range.t1} - double{range.t0};
  const double sigma = double{sigma_t[drawn.channel]};
  const double flown = sigma > 0 ? drawn.depth / sigma : double{kInfinity};
  FreeFlight flight;
  if (flown <= way) flight.t = static_cast<float>(double{range.t0} + flown);
  if (!flight.t) {
    flight.weight = flightPast(medium, static_cast<float>(way), channels);
  } else if (!isGrey(sigma_t)) {
    flight.weight = flightWeight(sigma_t * exp(-sigma_t * static_cast<float>(flown)), channels);
  }
  return flight;
}

Rgb flightPast(const UniformMedium& medium, float way, const Rgb& channels) {
  const Rgb sigma_t = medium.coefficients.sigma_t();
  return isGrey(sigma_t) ? Rgb(1) : flightWeight(exp(-sigma_t * way), channels);
}

}  // namespace brume
