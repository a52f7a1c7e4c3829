// SPDX-License-Identifier: Apache-2.0
// One segment of all paths of a wave, as PhotonTracer has them, for either kind of lanes.

#include "transport/free_flight.inl"
#include "transport/path_wave.inl"

// In parentheses, so that those of this namespace are meant and not brume's.
inline void advance(const UniformFlights::Box& box, PathWave& wave) {
  (dropEnded)(wave);
  (drawNumbers)(4, wave);
  (fly)(box, wave);
  (findSegmentsNear)(Bounds3{Vec3(0.5f), Vec3(1.5f)}, wave);
  if (!box.isGrey) (weighCollisions)(box, wave);
  (arriveInMedia)(wave);
  (rouletteInMedia)(1, wave);
  (scatterInMedia)(0.7f, kVolumePhotons.bits(), wave);
}
