// SPDX-License-Identifier: Apache-2.0
#include "core/parse/param_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/io/float_file.h"
#include "core/spectrum.h"

namespace brume {

namespace {

/// Far above what any plugin declares; the search for doubles takes its square.
constexpr std::size_t kMaxParams = 1000;

/// Why a number does not fit a float; null when it does.
const char* storeFloat(double value, float& out) {
  if (!(std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max())))
    return "is too large for a float";
  out = static_cast<float>(value);
  return nullptr;
}

// Where the numbers of a list go. A sink takes one number and returns what is wrong with it.

struct FloatSink {
  static constexpr std::size_t kGroup = 1;
  std::vector<float> list;
  const char* operator()(double value) {
    float v = 0;
    const char* problem = storeFloat(value, v);
    list.push_back(v);
    return problem;
  }
};

struct DoubleSink {
  static constexpr std::size_t kGroup = 1;
  std::vector<double> list;
  const char* operator()(double value) {
    list.push_back(value);
    return std::isfinite(value) ? nullptr : "is too large";
  }
};

struct IntSink {
  static constexpr std::size_t kGroup = 1;
  std::vector<int> list;
  const char* operator()(double value) {
    if (!(value >= std::numeric_limits<int>::min() && value <= std::numeric_limits<int>::max()))
      return "is too large for an integer";
    const int v = static_cast<int>(value);
    if (static_cast<double>(v) != value) return "is no integer";
    list.push_back(v);
    return nullptr;
  }
};

/// Groups of three floats: points, vectors, normals and colours.
template <class T>
struct TripleSink {
  static constexpr std::size_t kGroup = 3;
  std::vector<T> list;
  float part[3] = {};
  std::size_t filled = 0;
  const char* operator()(double value) {
    const char* problem = storeFloat(value, part[filled]);
    if (++filled == kGroup) {
      list.push_back(T(part[0], part[1], part[2]));
      filled = 0;
    }
    return problem;
  }
};

/// Two lists of equal length.
using Pairs = std::pair<std::vector<float>, std::vector<float>>;

Pairs splitPairs(const std::vector<float>& numbers, const std::string& what,
                 const SourceLocation& where) {
  if (numbers.size() % 2 != 0)
    throw SceneError(
        where, fmt::format("{} has {} numbers, but takes them in pairs", what, numbers.size()));
  Pairs pairs;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    pairs.first.push_back(numbers[i]);
    pairs.second.push_back(numbers[i + 1]);
  }
  return pairs;
}

Rgb rgbFromPairs(const Pairs& pairs, const std::string& what, const SourceLocation& where) {
  for (float wavelength : pairs.first)
    if (!(wavelength > 0))
      throw SceneError(where, fmt::format("{} has the wavelength {}; it takes pairs of a positive "
                                          "wavelength in nm and a value",
                                          what, wavelength));
  return rgbFromSamples(pairs.first, pairs.second);
}

}  // namespace

ParamSet ParamListReader::read(const SourceLocation& where) {
  ParamSet set(where);
  while (tokens_.peek().kind == Token::Kind::String) {
    Param param = readParam();
    if (set.find(param.type, param.name))
      log_.warning(param.where,
                   fmt::format("\"{} {}\" is given twice in this list; the later one counts",
                               toString(param.type), param.name));
    set.add(std::move(param));
    if (set.params().size() > kMaxParams)
      throw SceneError(where, fmt::format("more than {} parameters in one list", kMaxParams));
  }
  return set;
}

Param ParamListReader::readParam() {
  const ParamDeclaration decl = parseDeclaration(tokens_.next());
  Param param;
  param.type = decl.type;
  param.name = decl.name;
  param.where = decl.where;
  param.values = readValues(decl);
  return param;
}

bool ParamListReader::openList(const ParamDeclaration& decl) {
  const Token& token = tokens_.peek();
  if (token.kind == Token::Kind::Number || token.kind == Token::Kind::String) return false;
  if (token.kind == Token::Kind::Word && (token.text == "true" || token.text == "false"))
    throw SceneError(token.where,
                     fmt::format("{} needs its value in quotes: \"{}\"", decl.written, token.text));
  if (token.kind != Token::Kind::Open)
    throw SceneError(
        token.kind == Token::Kind::End ? decl.where : token.where,
        fmt::format("{} needs a value, but {} follows", decl.written, describe(token)));
  tokens_.next();
  return true;
}

void ParamListReader::checkOwnKind(const ParamDeclaration& decl, const Token& token,
                                   Token::Kind wanted) const {
  if (token.kind == wanted) return;
  if (token.kind == Token::Kind::End || token.kind == Token::Kind::Open)
    throw SceneError(decl.where,
                     fmt::format("the list of {} is not closed: ']' is missing before {}",
                                 decl.written, describe(token)));
  if (decl.kind == ValueKind::Bool)
    throw SceneError(token.where, fmt::format("{} takes \"true\" or \"false\" in quotes, not {}",
                                              decl.written, describe(token)));
  throw SceneError(token.where,
                   fmt::format("{} takes {}, not {}", decl.written,
                               wanted == Token::Kind::Number ? "numbers" : "strings in quotes",
                               describe(token)));
}

template <class Sink>
void ParamListReader::readNumberList(const ParamDeclaration& decl, bool isBracketed, Sink& sink) {
  std::size_t count = 0;
  const auto store = [&](double value) {
    ++count;
    return sink(value);
  };
  const auto storeToken = [&](const Token& token) {
    checkOwnKind(decl, token, Token::Kind::Number);
    if (const char* problem = store(token.number))
      throw SceneError(token.where, fmt::format("{} {}", token.number, problem));
  };

  if (!isBracketed) {
    storeToken(tokens_.next());
  } else {
    // Exact reservation: no growth by copying. One element more is what meshes add at the end.
    if (!tokens_.hasPeeked()) sink.list.reserve(tokens_.countNumbersAhead() / Sink::kGroup + 1);
    for (;;) {
      if (!tokens_.hasPeeked()) tokens_.readNumbers(store);
      const Token token = tokens_.next();  // goes on in the including file at the end of this one
      if (token.kind == Token::Kind::Close) break;
      storeToken(token);
    }
    if (sink.list.capacity() > sink.list.size() + sink.list.size() / 8 + 16)
      sink.list.shrink_to_fit();
  }
  if (count == 0)
    throw SceneError(decl.where, fmt::format("{} needs at least one value", decl.written));
  if (count % Sink::kGroup != 0)
    throw SceneError(decl.where, fmt::format("{} has {} numbers, but takes them in groups of {}",
                                             decl.written, count, Sink::kGroup));
}

std::vector<std::string> ParamListReader::readStrings(const ParamDeclaration& decl,
                                                      bool isBracketed) {
  std::vector<std::string> list;
  do {
    Token token = tokens_.next();
    if (isBracketed && token.kind == Token::Kind::Close) break;
    checkOwnKind(decl, token, Token::Kind::String);
    list.push_back(std::move(token.text));
  } while (isBracketed);
  if (list.empty())
    throw SceneError(decl.where, fmt::format("{} needs at least one value", decl.written));
  return list;
}

Param::Values ParamListReader::readValues(const ParamDeclaration& decl) {
  const bool isBracketed = openList(decl);
  switch (decl.kind) {
    case ValueKind::Float: {
      FloatSink sink;
      readNumberList(decl, isBracketed, sink);
      return std::move(sink.list);
    }
    case ValueKind::Integer: {
      IntSink sink;
      readNumberList(decl, isBracketed, sink);
      return std::move(sink.list);
    }
    case ValueKind::Point:
    case ValueKind::Vector:
    case ValueKind::Normal: {
      TripleSink<Vec3> sink;
      readNumberList(decl, isBracketed, sink);
      return std::move(sink.list);
    }
    case ValueKind::Bool:
      return readBools(decl, isBracketed);
    case ValueKind::String:
      return readStrings(decl, isBracketed);
    case ValueKind::Texture: {
      std::vector<std::string> names = readStrings(decl, isBracketed);
      if (names.size() != 1)
        throw SceneError(decl.where, fmt::format("{} takes one texture name, not {}", decl.written,
                                                 names.size()));
      return names;
    }
    default:
      return readColors(decl, isBracketed);
  }
}

Param::Values ParamListReader::readBools(const ParamDeclaration& decl, bool isBracketed) {
  std::vector<bool> list;
  for (const std::string& word : readStrings(decl, isBracketed)) {
    if (word != "true" && word != "false")
      throw SceneError(decl.where, fmt::format("{} takes \"true\" or \"false\", not {}",
                                               decl.written, quote(word)));
    list.push_back(word == "true");
  }
  return list;
}

/// Spectra become colours here, at the precision of the matching functions.
Param::Values ParamListReader::readColors(const ParamDeclaration& decl, bool isBracketed) {
  if (decl.kind == ValueKind::Rgb || decl.kind == ValueKind::Xyz) {
    TripleSink<Rgb> sink;
    readNumberList(decl, isBracketed, sink);
    if (decl.kind == ValueKind::Xyz)
      for (Rgb& c : sink.list) c = rgbFromXyz(c.r, c.g, c.b);
    return std::move(sink.list);
  }

  std::vector<Rgb> colors;
  if (decl.kind == ValueKind::Spectrum && tokens_.peek().kind == Token::Kind::String) {
    for (const std::string& name : readStrings(decl, isBracketed))
      colors.push_back(spectrumFile(decl, name));
    return colors;
  }

  FloatSink sink;
  readNumberList(decl, isBracketed, sink);
  const Pairs pairs = splitPairs(sink.list, decl.written, decl.where);
  if (decl.kind == ValueKind::Spectrum) {
    colors.push_back(rgbFromPairs(pairs, decl.written, decl.where));
  } else {
    for (std::size_t i = 0; i < pairs.first.size(); ++i)
      colors.push_back(rgbFromBlackbody(pairs.first[i]) * pairs.second[i]);
  }
  return colors;
}

Rgb ParamListReader::spectrumFile(const ParamDeclaration& decl, const std::string& name) {
  const std::string path = resolvePath(tokens_.searchDirectory(), name);
  if (const auto known = spectra_.find(path); known != spectra_.end()) return known->second;
  const SourceLocation inFile{internFileName(path), 0, 0};
  const Pairs pairs = splitPairs(readFloatFile(path, decl.where), "this spectrum", inFile);
  const Rgb color = rgbFromPairs(pairs, "this spectrum", inFile);
  spectra_.emplace(path, color);
  return color;
}

std::vector<double> ParamListReader::readMatrix(std::string_view directive) {
  constexpr std::size_t kEntries = 16;
  const Token open = tokens_.next();
  if (open.kind != Token::Kind::Open)
    throw SceneError(open.where, fmt::format("{} takes {} numbers in brackets, but {} follows",
                                             directive, kEntries, describe(open)));
  const ParamDeclaration decl{
      ValueKind::Float, ParamType::Float, std::string(directive), {}, open.where};
  DoubleSink sink;
  readNumberList(decl, true, sink);
  if (sink.list.size() != kEntries)
    throw SceneError(open.where, fmt::format("{} takes {} numbers, not {}", directive, kEntries,
                                             sink.list.size()));
  return std::move(sink.list);
}

}  // namespace brume
