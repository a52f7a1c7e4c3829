// SPDX-License-Identifier: Apache-2.0
// Segments: ITU-T T.81, annex B.
#include "core/io/jpeg_integrity.h"

#include <array>

#include "core/error.h"

namespace brume {
namespace {

enum Marker : unsigned char {
  kHuffmanTables = 0xc4,
  kProgressiveFrame = 0xc2,
  kFirstRestart = 0xd0,
  kLastRestart = 0xd7,
  kEndOfImage = 0xd9,
  kStartOfScan = 0xda,
  kQuantTables = 0xdb,
};

[[noreturn]] void truncated() { throw SceneError("truncated JPEG file"); }
[[noreturn]] void corrupt(const char* what) {
  throw SceneError(std::string("corrupt JPEG file: ") + what);
}

class JpegWalk {
 public:
  explicit JpegWalk(ByteSpan bytes) : bytes_(bytes) {}

  void run() {
    for (unsigned char marker = nextMarker(); marker != kEndOfImage; marker = nextMarker()) {
      const ByteSpan segment = takeSegment();
      switch (marker) {
        case kHuffmanTables:
          huffmanTables(segment);
          break;
        case kQuantTables:
          quantTables(segment);
          break;
        case 0xc0:
        case 0xc1:
        case kProgressiveFrame:
          frame(marker, segment);
          break;
        case kStartOfScan:
          scan(segment);
          break;
        default:
          break;
      }
    }
    for (const unsigned char table : quantTablesUsed_)
      if (!hasQuantTable_[table]) corrupt("a quantisation table is missing");
  }

 private:
  unsigned char at(std::size_t i) const {
    if (i >= bytes_.size()) truncated();
    return bytes_[i];
  }

  /// Skips to the next marker; stuffed zeros and restart markers belong to coded data.
  unsigned char nextMarker() {
    for (;;) {
      while (at(position_) != 0xff) ++position_;
      while (at(position_) == 0xff) ++position_;
      const unsigned char marker = at(position_++);
      const bool isData = marker == 0 || (marker >= kFirstRestart && marker <= kLastRestart);
      if (!isData) return marker;
    }
  }

  ByteSpan takeSegment() {
    const std::size_t length = static_cast<std::size_t>(at(position_)) << 8 | at(position_ + 1);
    if (length < 2) corrupt("a segment has no length");
    if (length > bytes_.size() - position_) truncated();
    const ByteSpan segment = bytes_.subspan(position_ + 2, length - 2);
    position_ += length;
    return segment;
  }

  void huffmanTables(ByteSpan s) {
    while (!s.empty()) {
      if (s.size() < 17) corrupt("bad Huffman table");
      const unsigned kind = s[0] >> 4, id = s[0] & 15u;
      std::size_t codes = 0;
      for (std::size_t i = 1; i <= 16; ++i) codes += s[i];
      if (kind > 1 || id > 3 || codes > 256 || s.size() < 17 + codes) corrupt("bad Huffman table");
      hasHuffmanTable_[kind][id] = true;
      s = s.subspan(17 + codes);
    }
  }

  void quantTables(ByteSpan s) {
    while (!s.empty()) {
      const std::size_t size = 1 + (s[0] >> 4 ? 128 : 64);
      if ((s[0] & 15u) > 3 || s.size() < size) corrupt("bad quantisation table");
      hasQuantTable_[s[0] & 15u] = true;
      s = s.subspan(size);
    }
  }

  void frame(unsigned char marker, ByteSpan s) {
    isProgressive_ = marker == kProgressiveFrame;
    if (s.size() < 6 || s.size() != 6u + 3u * s[5]) corrupt("bad frame header");
    for (std::size_t i = 0; i < s[5]; ++i) {
      const unsigned char table = s[8 + 3 * i];
      if (table > 3) corrupt("bad frame header");
      quantTablesUsed_.push_back(table);
    }
  }

  void scan(ByteSpan s) {
    if (s.empty() || s.size() != 4u + 2u * s[0]) corrupt("bad scan header");
    const unsigned char first = s[s.size() - 3], refinement = s[s.size() - 1] >> 4;
    // A progressive scan codes either DC, of which refinements are plain bits, or AC coefficients.
    const bool usesDc = !isProgressive_ || (first == 0 && refinement == 0);
    const bool usesAc = !isProgressive_ || first > 0;
    for (std::size_t i = 0; i < s[0]; ++i) {
      const unsigned dc = s[2 + 2 * i] >> 4, ac = s[2 + 2 * i] & 15u;
      if (dc > 3 || ac > 3 || (usesDc && !hasHuffmanTable_[0][dc]) ||
          (usesAc && !hasHuffmanTable_[1][ac]))
        corrupt("a Huffman table is missing");
    }
  }

  ByteSpan bytes_;
  std::size_t position_ = 2;  // behind the start marker
  bool isProgressive_ = false;
  std::array<std::array<bool, 4>, 2> hasHuffmanTable_{};
  std::array<bool, 4> hasQuantTable_{};
  Bytes quantTablesUsed_;
};

}  // namespace

void checkJpeg(ByteSpan bytes) { JpegWalk(bytes).run(); }

}  // namespace brume
