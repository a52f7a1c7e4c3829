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

FreeFlight sampleFreeFlight(const MediumAlongRay& medium, const Rgb& channels, float uChannel,
                            float uDepth) {
  const int channel = uChannel < channels.r                                   ? 0
                      : uChannel < channels.r + channels.g || channels.b == 0 ? 1
                                                                              : 2;
  // What chose the channel refines the depth as well: 24 bits alone would draw depths below 1e-6 by
  // the wrong probability.
  const double before = channel == 0   ? 0
                        : channel == 1 ? double{channels.r}
                                       : double{channels.r} + double{channels.g};
  const double rest = std::clamp((double{uChannel} - before) / double{channels[channel]}, 0.0,
                                 double{kOneMinusEpsilon});
  FreeFlight flight;
  flight.t = medium.invert(channel, -std::log1p(-(double{uDepth} + rest * 0x1p-24)));
  Rgb density = flight.t ? medium.at(*flight.t).sigma_t() * medium.transmittance(*flight.t)
                         : medium.transmittance();
  const Rgb drawn = channels * density;
  const float pdf = drawn.r + drawn.g + drawn.b;
  flight.weight = pdf > 0 ? density / pdf : Rgb();
  return flight;
}

}  // namespace brume
