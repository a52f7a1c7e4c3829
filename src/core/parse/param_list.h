// SPDX-License-Identifier: Apache-2.0
// Parameter lists: "type name" value or "type name" [values], decoded straight into typed lists.
#pragma once

#include <string>
#include <unordered_map>

#include "core/log.h"
#include "core/params.h"
#include "core/parse/param_declaration.h"
#include "core/parse/token_stream.h"

namespace brume {

/// Reads parameters up to the first token that is no string. Colours of all kinds become
/// ParamType::Color. Spectrum files are read once per reader.
class ParamListReader {
 public:
  ParamListReader(TokenStream& tokens, Log& log) : tokens_(tokens), log_(log) {}

  /// `where` becomes the place of the set: that of the directive.
  ParamSet read(const SourceLocation& where);
  /// Sixteen numbers in brackets.
  std::vector<double> readMatrix(std::string_view directive);

 private:
  Param readParam();
  Param::Values readValues(const ParamDeclaration& decl);
  Param::Values readColors(const ParamDeclaration& decl, bool isBracketed);
  Param::Values readBools(const ParamDeclaration& decl, bool isBracketed);
  template <class Sink>
  void readNumberList(const ParamDeclaration& decl, bool isBracketed, Sink& sink);
  std::vector<std::string> readStrings(const ParamDeclaration& decl, bool isBracketed);
  Rgb spectrumFile(const ParamDeclaration& decl, const std::string& name);
  /// Whether brackets surround the values. Fails when no value follows at all.
  bool openList(const ParamDeclaration& decl);
  void checkOwnKind(const ParamDeclaration& decl, const Token& token, Token::Kind wanted) const;

  TokenStream& tokens_;
  Log& log_;
  std::unordered_map<std::string, Rgb> spectra_;
};

}  // namespace brume
