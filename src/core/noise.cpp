// SPDX-License-Identifier: Apache-2.0
#include "core/noise.h"

#include <array>
#include <cstdint>

namespace brume {
namespace {

constexpr int kPeriod = 256;

/// The permutation published by Perlin 2002.
constexpr std::array<std::uint8_t, kPeriod> kPermutation{
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103,
    30,  69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,
    197, 62,  94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174,
    20,  125, 136, 171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231,
    83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143,
    54,  65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196,
    135, 130, 116, 188, 159, 86,  164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124,
    123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,
    182, 189, 28,  42,  223, 183, 170, 213, 119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101,
    155, 167, 43,  172, 9,   129, 22,  39,  253, 19,  98,  108, 110, 79,  113, 224, 232, 178, 185,
    112, 104, 218, 246, 97,  228, 251, 34,  242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,
    51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,  181, 199, 106, 157, 184, 84,  204, 176,
    115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,  222, 114, 67,  29,  24,  72,  243,
    141, 128, 195, 78,  66,  215, 61,  156, 180};

int permute(int i) { return kPermutation[static_cast<std::size_t>(i & (kPeriod - 1))]; }

/// Dot product of the offset d with one of twelve edge directions (four of them twice), chosen by
/// the lattice point.
float gradient(int x, int y, int z, float dx, float dy, float dz) {
  const int h = permute(permute(permute(x) + y) + z) & 15;
  const float u = h < 8 || h == 12 || h == 13 ? dx : dy;
  const float v = h < 4 || h == 12 || h == 13 ? dy : dz;
  return ((h & 1) ? -u : u) + ((h & 2) ? -v : v);
}

/// 6 t^5 - 15 t^4 + 10 t^3: first and second derivative vanish at 0 and 1.
float fade(float t) {
  const float t3 = t * t * t, t4 = t3 * t;
  return 6 * t4 * t - 15 * t4 + 10 * t3;
}

/// A coordinate as lattice cell modulo the period, and the offset in it.
struct Cell {
  int index;
  float offset;
  explicit Cell(float x) {
    const float cell = std::floor(x);
    // Beyond 2^31 every float is a multiple of the period.
    index = std::abs(cell) < 0x1p31f ? static_cast<int>(cell) & (kPeriod - 1) : 0;
    offset = x - cell;
  }
};

/// How many octaves the footprint admits, with a fraction for the one that fades.
float octaveCount(const Vec3& dpdx, const Vec3& dpdy, int maxOctaves) {
  constexpr float kFewest = -64;  // where the square of the footprint overflows
  const float width2 = std::max(lengthSquared(dpdx), lengthSquared(dpdy));
  const float count = std::min(static_cast<float>(maxOctaves), 1 - .5f * std::log2(width2));
  return count >= kFewest ? count : kFewest;
}

float smoothStep(float lo, float hi, float x) {
  const float v = std::clamp((x - lo) / (hi - lo), 0.f, 1.f);
  return v * v * (3 - 2 * v);
}

/// Sum of omega^i value(noise(1.99^i p)): whole octaves, then the fading one.
template <class Value>
float sumOctaves(const Vec3& p, float octaves, float omega, const Value& value) {
  constexpr float kLacunarity = 1.99f;  // not 2: the zeros of the octaves must not coincide
  const float whole = std::floor(octaves);
  float sum = 0, frequency = 1, weight = 1;
  for (int i = 0; i < static_cast<int>(whole); ++i) {
    sum += weight * value(noise(frequency * p));
    frequency *= kLacunarity;
    weight *= omega;
  }
  const float fading = smoothStep(.3f, .7f, octaves - whole);
  return fading > 0 ? sum + weight * fading * value(noise(frequency * p)) : sum;
}

}  // namespace

float noise(const Vec3& p) {
  if (!isFinite(p)) return 0;
  const Cell x(p.x), y(p.y), z(p.z);
  const float fx = fade(x.offset), fy = fade(y.offset), fz = fade(z.offset);
  const auto corner = [&](int i, int j, int k) {
    return gradient(x.index + i, y.index + j, z.index + k, x.offset - static_cast<float>(i),
                    y.offset - static_cast<float>(j), z.offset - static_cast<float>(k));
  };
  const auto edge = [&](int j, int k) { return lerp(corner(0, j, k), corner(1, j, k), fx); };
  const auto face = [&](int k) { return lerp(edge(0, k), edge(1, k), fy); };
  return lerp(face(0), face(1), fz);
}

float fbm(const Vec3& p, const Vec3& dpdx, const Vec3& dpdy, float omega, int octaves) {
  return sumOctaves(p, octaveCount(dpdx, dpdy, octaves), omega, [](float n) { return n; });
}

float turbulence(const Vec3& p, const Vec3& dpdx, const Vec3& dpdy, float omega, int octaves) {
  constexpr float kMeanAbsNoise = .2f;
  const float count = octaveCount(dpdx, dpdy, octaves);
  const float sum = sumOctaves(p, count, omega, [](float n) { return std::abs(n); });
  return sum + (static_cast<float>(octaves) - count) * kMeanAbsNoise;
}

}  // namespace brume
