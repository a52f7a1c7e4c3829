// SPDX-License-Identifier: Apache-2.0
#include "core/io/exr_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <half.h>

#include <cstring>
#include <exception>

#include "core/io/exr_header.h"

namespace brume {
namespace {

/// A stream over bytes in memory; reading past the end throws, as the library expects.
class MemoryStream final : public Imf::IStream {
 public:
  MemoryStream(ByteSpan bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}

  bool read(char target[], int size) override {
    const auto n = static_cast<std::size_t>(size);
    if (size < 0 || position_ > bytes_.size() || n > bytes_.size() - position_)
      throw std::runtime_error("unexpected end of file");
    std::memcpy(target, bytes_.data() + position_, n);
    position_ += n;
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  ByteSpan bytes_;
  std::size_t position_ = 0;
};

/// Writes into an AtomicFile. The library's destructors swallow exceptions, so the first failure is
/// kept and rethrown by check().
class FileStream final : public Imf::OStream {
 public:
  explicit FileStream(AtomicFile& file) : OStream(""), file_(file) {}

  void write(const char source[], int size) override {
    guarded([&] { file_.write(source, static_cast<std::size_t>(size)); });
  }
  std::uint64_t tellp() override { return file_.position(); }
  void seekp(std::uint64_t position) override {
    guarded([&] { file_.seek(position); });
  }
  void check() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  template <class F>
  void guarded(const F& action) {
    try {
      action();
    } catch (...) {
      if (!failure_) failure_ = std::current_exception();
      throw;
    }
  }

  AtomicFile& file_;
  std::exception_ptr failure_;
};

/// Attributes that describe the storage of a part, not the picture.
bool isStructural(const std::string& attribute) {
  return attribute == "type" || attribute == "name" || attribute == "view";
}

LayeredImage decode(Imf::InputFile& file, const std::function<bool(const std::string&)>& wanted) {
  const Imf::Header& header = file.header();
  const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
  LayeredImage image;
  // Windows are kept relative to the corner of the display window.
  const auto offset = [](int a, int b) {
    const std::int64_t d = std::int64_t{a} - b;
    if (d < std::numeric_limits<int>::min() / 2 || d > std::numeric_limits<int>::max() / 2)
      throw SceneError("corrupt EXR header: the windows are too far apart");
    return static_cast<int>(d);
  };
  image.displaySize = {offset(display.max.x, display.min.x) + 1,
                       offset(display.max.y, display.min.y) + 1};
  image.dataWindow.lo = {offset(data.min.x, display.min.x), offset(data.min.y, display.min.y)};
  image.dataWindow.hi = {offset(data.max.x, display.min.x) + 1,
                         offset(data.max.y, display.min.y) + 1};
  for (auto it = header.begin(); it != header.end(); ++it) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
    if (text && !isStructural(it.name())) image.metadata[it.name()] = text->value();
  }

  Imf::FrameBuffer frame;
  const auto area = static_cast<std::size_t>(image.dataWindow.area());
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (!wanted(it.name())) continue;
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
      throw SceneError(
          fmt::format("channel '{}' is subsampled, which is not supported; convert the "
                      "image to R, G, B",
                      it.name()));
    std::vector<float>& values = image.channels[it.name()];
    values.resize(area);
    frame.insert(it.name(), Imf::Slice::Make(Imf::FLOAT, values.data(), data));
  }
  if (!image.channels.empty()) {
    file.setFrameBuffer(frame);
    file.readPixels(data.min.y, data.max.y);
  }
  return image;
}

half toHalf(float value) {
  if (!std::isfinite(value)) return half(value);
  return half(std::clamp(value, -kLargestHalf, kLargestHalf));
}

/// Channels that are no colours have values beyond those of half.
bool isColour(const std::string& channel) {
  return !channel.starts_with("variance.") && channel != "samples" && channel != "depth.Z";
}

}  // namespace

LayeredImage decodeExr(ByteSpan bytes, const std::string& name,
                       const std::function<bool(const std::string&)>& wanted) {
  checkExrHeader(bytes);
  try {
    MemoryStream stream(bytes, name);
    Imf::InputFile file(stream);
    return decode(file, wanted);
  } catch (const SceneError&) {
    throw;
  } catch (const std::exception& e) {
    throw SceneError(fmt::format("corrupt or truncated EXR file: {}", e.what()));
  }
}

void writeExr(AtomicFile& out, const LayeredImage& image, PixelPrecision precision) {
  const Bounds2i& window = image.dataWindow;
  const Imath::Box2i data({window.lo.x, window.lo.y}, {window.hi.x - 1, window.hi.y - 1});
  const Imath::Box2i display({0, 0}, {image.displaySize.x - 1, image.displaySize.y - 1});
  Imf::Header header(display, data);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [key, value] : image.metadata) {
    BRUME_CHECK(!key.empty() && header.find(key.c_str()) == header.end());
    header.insert(key, Imf::StringAttribute(value));
  }

  Imf::FrameBuffer frame;
  std::vector<std::vector<half>> halves;  // what the frame buffer points to
  const auto area = static_cast<std::size_t>(window.area());
  for (const auto& [name, values] : image.channels) {
    BRUME_CHECK(values.size() == area);
    const bool isHalf = precision == PixelPrecision::Half && isColour(name);
    const Imf::PixelType type = isHalf ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(name, Imf::Channel(type));
    const void* pixels = values.data();
    if (isHalf) {
      std::vector<half>& converted = halves.emplace_back(area);
      std::transform(values.begin(), values.end(), converted.begin(), toHalf);
      pixels = converted.data();
    }
    frame.insert(name, Imf::Slice::Make(type, pixels, data));
  }

  FileStream stream(out);
  try {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame);
    file.writePixels(window.height());
  } catch (const std::exception& e) {
    stream.check();
    throw SceneError(e.what());
  }
  stream.check();
}

}  // namespace brume
