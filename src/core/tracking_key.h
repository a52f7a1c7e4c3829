// SPDX-License-Identifier: Apache-2.0
// What keys the random numbers of tracked media beside the ray itself.
#pragma once

#include <cstdint>

namespace brume {

/// Tracked media draw their tentative collisions from the ray's bits and this key, so that whoever
/// asks for a transmittance need not hand random numbers down. Camera rays may be the same in every
/// sample of a pixel: whoever draws camera samples sets the key of each in its thread, from the
/// seed, the pixel and the sample's number. Other rays start or end at random points.
inline std::uint64_t& trackingKey() {
  thread_local std::uint64_t key = 0;
  return key;
}

/// Sets the key as long as it lives.
class TrackingKeyScope {
 public:
  explicit TrackingKeyScope(std::uint64_t key) : before_(trackingKey()) { trackingKey() = key; }
  ~TrackingKeyScope() { trackingKey() = before_; }
  TrackingKeyScope(const TrackingKeyScope&) = delete;
  TrackingKeyScope& operator=(const TrackingKeyScope&) = delete;

 private:
  std::uint64_t before_;
};

}  // namespace brume
