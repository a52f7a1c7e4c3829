// SPDX-License-Identifier: Apache-2.0
#include "materials/lobes_measured.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>

#include "core/io/file_bytes.h"
#include "core/spectrum.h"
#include "materials/lobes_microfacet.h"

namespace brume {

namespace {

/// readFileBytes with the place in the scene that named the file.
Bytes readAt(const std::string& path, std::uint64_t limit, const SourceLocation& where) {
  try {
    return readFileBytes(path, limit);
  } catch (const SceneError& error) {
    throw SceneError(where, error.what());
  }
}

/// Azimuth in [0, 2 pi).
float azimuth(const Vec3& w) {
  const float phi = std::atan2(w.y, w.x);
  return phi < 0.f ? phi + 2.f * kPi : phi;
}

int clampedIndex(float x, int count) {
  return std::clamp(static_cast<int>(x * static_cast<float>(count)), 0, count - 1);
}

}  // namespace

// --- MERL ----------------------------------------------------------------------------------------

namespace {

// A MERL file has one size only; anything else is cut short or no such file.
constexpr std::size_t kEntries =
    std::size_t{MerlBrdf::kThetaH} * MerlBrdf::kThetaD * MerlBrdf::kPhiD;
constexpr std::size_t kHeader = 3 * sizeof(std::int32_t);
constexpr std::size_t kSize = kHeader + 3 * kEntries * sizeof(double);

bool startsAsMerl(ByteSpan bytes) {
  static_assert(std::endian::native == std::endian::little);
  std::int32_t dims[3] = {0, 0, 0};
  if (bytes.size() >= kHeader) std::memcpy(dims, bytes.data(), kHeader);
  return dims[0] == MerlBrdf::kThetaH && dims[1] == MerlBrdf::kThetaD && dims[2] == MerlBrdf::kPhiD;
}

}  // namespace

bool MerlBrdf::hasUsualHead(const std::string& path) {
  const auto file = FilePieces::open(path);
  return file && file->size() == kSize && startsAsMerl(file->read(0, kHeader));
}

double MerlBrdf::bytesOf(const std::string&) { return double{kEntries} * sizeof(Rgb); }

MerlBrdf::MerlBrdf(const std::string& path, const SourceLocation& where) {
  const Bytes bytes = readAt(path, std::uint64_t{1} << 30, where);
  if (!startsAsMerl(bytes))
    throw SceneError(
        where, fmt::format("'{}' is not a measured BRDF in the MERL format: it must start with the "
                           "32-bit integers 90 90 180 (text files need the suffix .brdf)",
                           path));
  if (bytes.size() != kSize)
    throw SceneError(
        where, fmt::format("the BRDF file '{}' is {}: {} bytes instead of {}", path,
                           bytes.size() < kSize ? "cut short" : "too long", bytes.size(), kSize));

  table_.resize(kEntries);
  constexpr double kScale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
  const unsigned char* p = bytes.data() + kHeader;
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < kEntries; ++i, p += sizeof(double)) {
      double v;
      std::memcpy(&v, p, sizeof v);
      const float scaled = static_cast<float>(std::max(0.0, v * kScale[c]));
      if (!std::isfinite(v) || !std::isfinite(scaled))
        throw SceneError(where, fmt::format("the BRDF file '{}' holds the value {} at byte {}",
                                            path, v, p - bytes.data()));
      table_[i][c] = scaled;
    }
  tabulateHalfVectors();
}

int MerlBrdf::thetaHIndex(float theta) {
  return clampedIndex(std::sqrt(theta * (2.f * kInvPi)), kThetaH);
}

void MerlBrdf::tabulateHalfVectors() {
  for (int h = 0; h <= kThetaH; ++h) {
    const double theta = sqr(static_cast<double>(h) / kThetaH) * 1.5707963267948966;
    oneMinusCos_[h] = static_cast<float>(2 * sqr(std::sin(theta / 2)));
  }
  // The mean of the table over each row, by the projected solid angle of wd, times that of wh.
  std::vector<float> weights(kThetaH);
  for (int h = 0; h < kThetaH; ++h) {
    double sum = 0;
    for (int d = 0; d < kThetaD; ++d) {
      double row = 0;
      for (int i = 0; i < kPhiD; ++i)
        row += table_[static_cast<std::size_t>((h * kThetaD + d) * kPhiD + i)].luminance();
      sum += row * std::sin(3.14159265358979 * (d + .5) / kThetaD);
    }
    const double meanCos = 1 - .5 * (oneMinusCos_[h] + oneMinusCos_[h + 1]);
    weights[h] = static_cast<float>(sum * meanCos * (oneMinusCos_[h + 1] - oneMinusCos_[h]));
  }
  thetaH_ = Distribution1D(weights);
  for (int h = 0; h < kThetaH; ++h)
    pdfOfRow_[h] = thetaH_.probability(h) / (2.f * kPi * (oneMinusCos_[h + 1] - oneMinusCos_[h]));
}

Rgb MerlBrdf::f(const Vec3& wo, const Vec3& wi) const {
  const auto h = halfVector(wo, wi);
  if (!h) return Rgb();
  const float side = h->wh.z < 0.f ? -1.f : 1.f;
  const Vec3 wh = side * h->wh, w = side * wi;

  // wi in the frame of wh: x points away from the normal.
  const float cosP = cosPhi(wh), sinP = sinPhi(wh), sine = sinTheta(wh);
  const Vec3 x{cosP * wh.z, sinP * wh.z, -sine}, y{-sinP, cosP, 0};
  float phiD = std::atan2(dot(w, y), dot(w, x));
  if (phiD < 0.f) phiD += kPi;  // reciprocity: phi_d and phi_d + pi are one entry

  const int iH = thetaHIndex(std::atan2(sine, wh.z));
  const int iD = clampedIndex(safeAcos(h->cosine) * (2.f * kInvPi), kThetaD);
  const int iP = clampedIndex(phiD * kInvPi, kPhiD);
  return table_[static_cast<std::size_t>((iH * kThetaD + iD) * kPhiD + iP)];
}

Vec3 MerlBrdf::sampleHalfVector(Vec2 u) const {
  const Distribution1D::Sample row = thetaH_.sample(u.x);
  // Uniform in cos within the row.
  const float within = row.x * static_cast<float>(kThetaH) - static_cast<float>(row.index);
  const float oneMinusCos =
      lerp(oneMinusCos_[row.index], oneMinusCos_[row.index + 1], std::clamp(within, 0.f, 1.f));
  const float sine = safeSqrt(oneMinusCos * (2.f - oneMinusCos));
  const float phi = 2.f * kPi * u.y;
  return {sine * std::cos(phi), sine * std::sin(phi), 1.f - oneMinusCos};
}

float MerlBrdf::pdfHalfVector(const Vec3& wh) const {
  // By the sine, as the rows near the pole are narrower than the cosine can tell.
  return pdfOfRow_[thetaHIndex(std::atan2(sinTheta(wh), absCosTheta(wh)))];
}

float MerlLobe::pdf(const Vec3& wo, const Vec3& wi) const {
  if (!sameHemisphere(wo, wi)) return 0.f;
  const auto h = halfVector(wo, wi);
  const float byHalfVector = h ? brdf_->pdfHalfVector(h->wh) / (4.f * h->cosine) : 0.f;
  return .5f * (absCosTheta(wi) * kInvPi + byHalfVector);
}

std::optional<BsdfSample> MerlLobe::sample(const Vec3& wo, Vec2 u) const {
  Vec3 wi;
  if (u.x < .5f) {
    wi = sampleCosineHemisphere({2.f * u.x, u.y});
    if (wo.z < 0.f) wi.z = -wi.z;
  } else {
    const auto reflected = reflectAbout(wo, brdf_->sampleHalfVector({2.f * (u.x - .5f), u.y}));
    if (!reflected) return std::nullopt;
    wi = *reflected;
  }
  const BsdfValue value = evaluate(wo, wi);
  if (!(value.pdf > 0.f)) return std::nullopt;
  return BsdfSample{value.f, wi, value.pdf, flags()};
}

// --- irregular samples ---------------------------------------------------------------------------

namespace {

/// All numbers of a text; blanks separate them, # starts a comment.
std::vector<float> readNumbers(const Bytes& bytes, const std::string& path,
                               const SourceLocation& where) {
  std::vector<float> numbers;
  const char* p = reinterpret_cast<const char*>(bytes.data());
  const char* const end = p + bytes.size();
  int line = 1;
  while (p < end) {
    if (*p == '#') {
      while (p < end && *p != '\n') ++p;
    } else if (*p == ' ' || *p == '\t' || *p == '\r' || *p == '\n') {
      line += *p++ == '\n' ? 1 : 0;
    } else {
      float v = 0;
      const char* start = *p == '+' ? p + 1 : p;
      const auto [next, error] = std::from_chars(start, end, v);
      if (error != std::errc() || !std::isfinite(v))
        throw SceneError(where, fmt::format("the BRDF file '{}' has something other than a number "
                                            "in line {}",
                                            path, line));
      numbers.push_back(v);
      p = next;
    }
  }
  return numbers;
}

Vec3 sphericalDirection(float theta, float phi) {
  const float sine = std::sin(theta);
  return {sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)};
}

}  // namespace

namespace {

constexpr std::uint64_t kMaxTextBytes = std::uint64_t{64} << 20;
constexpr std::size_t kMaxWavelengths = 1000;

bool isNumberOfWavelengths(float n) { return n >= 1 && n <= kMaxWavelengths && n == std::floor(n); }

}  // namespace

bool IrregularBrdf::hasUsualHead(const std::string& path) {
  constexpr std::size_t kLooked = std::size_t{1} << 16;
  const auto file = FilePieces::open(path);
  if (!file || file->size() <= kLooked || file->size() > kMaxTextBytes) return false;
  Bytes head = file->read(0, kLooked);
  while (!head.empty() && head.back() != '\n') head.pop_back();  // what was cut off
  try {
    const std::vector<float> numbers = readNumbers(head, path, {});
    return !numbers.empty() && isNumberOfWavelengths(numbers[0]) &&
           static_cast<float>(numbers.size()) >= 5 + 2 * numbers[0];
  } catch (const SceneError&) {
    return false;
  }
}

double IrregularBrdf::bytesOf(const std::string& path) {
  constexpr double kCharactersOfNumber = 8;
  const auto file = FilePieces::open(path);
  return file ? static_cast<double>(file->size()) / kCharactersOfNumber * sizeof(float) : 0;
}

IrregularBrdf::IrregularBrdf(const std::string& path, const SourceLocation& where) {
  const std::vector<float> numbers = readNumbers(readAt(path, kMaxTextBytes, where), path, where);
  const auto fail = [&](const std::string& reason) {
    throw SceneError(where, fmt::format("the BRDF file '{}' {}", path, reason));
  };

  // The header, and a body of whole samples.
  if (numbers.empty()) fail("is empty");
  if (!isNumberOfWavelengths(numbers[0]))
    fail(fmt::format("starts with {}; the number of wavelengths must be an integer from 1 to {}",
                     numbers[0], kMaxWavelengths));
  const std::size_t n = static_cast<std::size_t>(numbers[0]), stride = 4 + n, body = 1 + n;
  if (numbers.size() < body + stride) fail("has no sample");
  if ((numbers.size() - body) % stride != 0)
    fail(
        fmt::format("is cut short or has numbers to spare: after {} wavelengths, {} numbers are "
                    "not a multiple of {}",
                    n, numbers.size() - body, stride));

  // Conversion to RGB is linear: the colours of unit spectra serve all samples.
  const std::span<const float> wavelengths(numbers.data() + 1, n);
  std::vector<Rgb> unitColors(n);
  std::vector<float> unit(n, 0.f);
  for (std::size_t i = 0; i < n; ++i) {
    unit[i] = 1;
    unitColors[i] = rgbFromSamples(wavelengths, unit);
    unit[i] = 0;
  }
  std::vector<Sample> samples;
  samples.reserve((numbers.size() - body) / stride);
  for (std::size_t at = body; at < numbers.size(); at += stride) {
    const float* v = numbers.data() + at;
    Rgb color;
    for (std::size_t i = 0; i < n; ++i) color += unitColors[i] * v[4 + i];
    samples.push_back(
        {remap(sphericalDirection(v[2], v[3]), sphericalDirection(v[0], v[1])), color});
  }
  sortIntoGrid(samples);
}

Vec3 IrregularBrdf::remap(const Vec3& wo, const Vec3& wi) {
  const float dphi = std::abs(azimuth(wi) - azimuth(wo));
  return {sinTheta(wi) * sinTheta(wo), std::min(dphi, 2.f * kPi - dphi) * kInvPi,
          cosTheta(wi) * cosTheta(wo)};
}

int IrregularBrdf::cellOf(float m, int axis) const {
  const float cell = (m - lo_[axis]) * cellsPerUnit_[axis];
  return cell > 0.f ? static_cast<int>(std::min(cell, static_cast<float>(resolution_ - 1))) : 0;
}

void IrregularBrdf::sortIntoGrid(const std::vector<Sample>& samples) {
  // About one sample per cell; cells need not be smaller than the first search radius.
  constexpr double kMaxResolution = 32;
  resolution_ = static_cast<int>(
      std::clamp(std::cbrt(static_cast<double>(samples.size())), 1.0, kMaxResolution));
  Bounds3 bounds;
  for (const Sample& s : samples) bounds.extend(s.m);
  lo_ = bounds.lo;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = bounds.diagonal()[axis];
    cellsPerUnit_[axis] = extent > 1e-6f ? static_cast<float>(resolution_) / extent : 0.f;
  }

  // A counting sort by cell.
  const auto cell = [&](const Vec3& m) {
    return static_cast<std::size_t>((cellOf(m.z, 2) * resolution_ + cellOf(m.y, 1)) * resolution_ +
                                    cellOf(m.x, 0));
  };
  first_.assign(static_cast<std::size_t>(resolution_ * resolution_ * resolution_) + 1, 0);
  for (const Sample& s : samples) ++first_[cell(s.m) + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  samples_.resize(samples.size());
  for (const Sample& s : samples) samples_[next[cell(s.m)]++] = s;
}

Rgb IrregularBrdf::f(const Vec3& wo, const Vec3& wi) const {
  constexpr float kFirstRadius2 = .001f, kLastRadius2 = 1.5f, kSharpness = 100.f;
  constexpr float kDiameter = 3.f;  // of the space of m: more than sqrt(1 + 1 + 4)
  constexpr int kEnough = 3;
  const Vec3 m = remap(wo, wi);
  for (float radius2 = kFirstRadius2;; radius2 *= 2) {
    const bool isLast = radius2 > kLastRadius2;  // takes all
    const float radius = isLast ? kDiameter : std::sqrt(radius2);
    int lo[3], hi[3];
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = cellOf(m[axis] - radius, axis);
      hi[axis] = cellOf(m[axis] + radius, axis);
    }
    double sum[3] = {0, 0, 0}, weights = 0;  // double: exp(-100 * 6) is not yet 0
    int found = 0;
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y) {
        const std::size_t row = static_cast<std::size_t>((z * resolution_ + y) * resolution_);
        for (std::uint32_t i = first_[row + lo[0]]; i < first_[row + hi[0] + 1]; ++i) {
          const float d2 = lengthSquared(samples_[i].m - m);
          if (!isLast && d2 >= radius2) continue;
          const double weight = std::exp(-static_cast<double>(kSharpness * d2));
          for (int c = 0; c < 3; ++c) sum[c] += weight * samples_[i].value[c];
          weights += weight;
          ++found;
        }
      }
    if (found < kEnough && !isLast) continue;
    Rgb result;
    for (int c = 0; c < 3; ++c) result[c] = static_cast<float>(std::max(0.0, sum[c] / weights));
    return result;
  }
}

}  // namespace brume
