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
  flight.t = medium.invert(drawn.channel, drawn.depth);
  flight.weight =
      flightWeight(flight.t ? medium.at(*flight.t).sigma_t() * medium.transmittance(*flight.t)
                            : medium.transmittance(),
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

std::optional<UniformFlights> UniformFlights::through(const Volume& volume) {
  const auto medium = volume.uniform();
  std::vector<MediumBox> boxes;
  volume.appendBoxes(boxes);
  if (!medium || boxes.size() != 1) return std::nullopt;
  return UniformFlights(*medium, boxes.front());
}

UniformFlights::UniformFlights(const UniformMedium& medium, const MediumBox& box)
    : medium_(medium), sigma_t_(medium.coefficients.sigma_t()), isGrey_(isGrey(sigma_t_)) {
  for (int c = 0; c < 3; ++c)
    perSigma_[c] = sigma_t_[c] > 0 ? 1 / double{sigma_t_[c]} : double{kInfinity};
  excess_ = sigma_t_ - Rgb(sigma_t_.minChannel());
  for (std::size_t a = 0; a < 3; ++a) {
    axes_[a] = box.normal[2 * a + 1];
    lo_[a] = -box.offset[2 * a];
    hi_[a] = box.offset[2 * a + 1];
  }
}

bool UniformFlights::contains(const Vec3d& p) const {
  bool isInside = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const double place = dot(axes_[a], p);
    isInside = isInside && place >= lo_[a] && place <= hi_[a];
  }
  return isInside;
}

/// Rays in the plane of a face are inside.
std::optional<Interval> UniformFlights::clip(const Ray& ray) const {
  const Vec3d o(ray.o), d(ray.d);
  double t0 = 0, t1 = double{kInfinity};
  for (std::size_t a = 0; a < 3; ++a) {
    const double place = dot(axes_[a], o), inverse = 1 / dot(axes_[a], d);
    if (!std::isfinite(inverse)) {
      if (!(place >= lo_[a] && place <= hi_[a])) return std::nullopt;
      continue;
    }
    const double tLo = (lo_[a] - place) * inverse, tHi = (hi_[a] - place) * inverse;
    t0 = std::max(t0, std::min(tLo, tHi));
    t1 = std::min(t1, std::max(tLo, tHi));
  }
  if (!(t0 < t1)) return std::nullopt;
  return Interval{static_cast<float>(t0), static_cast<float>(t1)};
}

std::optional<UniformFlights::Flight> UniformFlights::sample(const Ray& ray, Start start,
                                                             const Rgb& power, Vec2 u) const {
  Flight flight;
  if (start == Start::Anywhere) {
    const auto range = clip(ray);
    if (!range) return std::nullopt;
    flight.range = *range;
  }
  if (!isGrey_) flight.channels = flightChannels(power);
  const DrawnDepth drawn = isGrey_ ? DrawnDepth(u.x, u.y) : DrawnDepth(flight.channels, u.x, u.y);
  const double t = double{flight.range.t0} + drawn.depth * perSigma_[drawn.channel];
  if (start == Start::Anywhere) {
    flight.collides = t <= double{flight.range.t1};
  } else {
    // Where it collides shows whether it does: the end of the medium is rarely asked for.
    flight.collides = t < double{kInfinity} && contains(Vec3d(ray.o) + t * Vec3d(ray.d));
    if (!flight.collides && !isGrey_) flight.range = clip(ray).value_or(Interval{});
  }
  if (flight.collides) flight.range.t1 = static_cast<float>(t);
  return flight;
}

/// Transmittance over that of the least channel: weights need no more, and it does not vanish.
Rgb UniformFlights::relativeTr(float way) const {
  Rgb Tr(1);
  for (int c = 0; c < 3; ++c)
    if (excess_[c] > 0) Tr[c] = std::exp(-excess_[c] * way);
  return Tr;
}

Rgb UniformFlights::weightAtCollision(const Flight& flight) const {
  if (isGrey_) return Rgb(1);
  return flightWeight(sigma_t_ * relativeTr(flight.range.length()), flight.channels);
}

Rgb UniformFlights::weightAt(const Flight& flight, float t) const {
  if (isGrey_) return Rgb(1);
  const float way = std::max(0.f, std::min(t, flight.range.t1) - flight.range.t0);
  return flightWeight(relativeTr(way), flight.channels);
}

}  // namespace brume
