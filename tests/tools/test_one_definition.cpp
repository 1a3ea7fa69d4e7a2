// No two files define the same name at namespace scope. Compilers and linkers do not notice two classes of one name:
// the program then uses the inline functions of either.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf::test_one_definition {

namespace {

namespace fs = std::filesystem;

/// The source without comments, literals and preprocessor lines.
std::string code_of(std::string_view text) {
  static const std::regex kNoCode(
      R"rx(//[^\n]*|/\*[^]*?\*/|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)+'|(?:^|\n)[ \t]*#(?:[^\n\\]|\\[^])*)rx");
  static const std::regex kRawString(R"rx(R"(\w*)\([^]*?\)\1")rx");
  const std::string without_raw = std::regex_replace(std::string(text), kRawString, "");
  return std::regex_replace(without_raw, kNoCode, " ");
}

/// The name that a declaration at namespace scope defines: a type, an alias, a concept or a constant. Empty for others,
/// among them functions, which may have overloads, and specializations of templates.
std::string defined_name(const std::string& declaration, bool has_body) {
  static const std::regex kType(
      R"((?:struct|class|union|enum(?: class| struct)?)\s+(?:alignas\([^)]*\)\s*)?(\w+)\s*(?:(?:final\s*)?(?::(?!:)[^]*)?))");
  static const std::regex kAlias(R"((?:using|concept)\s+(\w+)\s*=[^]*)");
  static const std::regex kConstant(R"((?:inline\s+)?constexpr\s+[\w:<>,\s*&]+?\b(k[A-Z]\w*)\s*(?:=[^]*|\[[^]*)?)");
  static const std::regex kTemplate(
      R"(\s*template\s*<[^{};]*?>\s*(?=struct|class|union|using|concept|inline|constexpr))");
  const std::string plain = std::regex_replace(declaration, kTemplate, "", std::regex_constants::format_first_only);
  static const std::regex kSpaces(R"(^\s+|\s+$)");
  const std::string trimmed = std::regex_replace(plain, kSpaces, "");
  std::smatch match;
  if (has_body && std::regex_match(trimmed, match, kType)) return match[1];
  if (std::regex_match(trimmed, match, kAlias) || std::regex_match(trimmed, match, kConstant)) return match[1];
  return "";
}

/// Names that the source defines at the scope of a named namespace, with that namespace.
std::set<std::string> defined_names(std::string_view text) {
  static const std::regex kNamespace(R"(\s*(?:inline\s+)?namespace\s*([\w:]*)\s*)");
  const std::string code = code_of(text);
  std::set<std::string> names;
  std::vector<std::string> scopes;  // namespaces; "" for one without a name, and for any other braces
  std::string declaration;
  const auto is_in_namespaces = [&] {
    return std::none_of(scopes.begin(), scopes.end(), [](const std::string& scope) { return scope.empty(); });
  };
  const auto add = [&](bool has_body) {
    std::string name = is_in_namespaces() ? defined_name(declaration, has_body) : "";
    if (name.empty()) return;
    for (auto scope = scopes.rbegin(); scope != scopes.rend(); ++scope) name.insert(0, *scope + "::");
    names.insert(name);
  };
  for (const char c : code) {
    if (c == '{') {
      std::smatch match;
      const bool opens_namespace = std::regex_match(declaration, match, kNamespace);
      if (!opens_namespace) add(true);
      scopes.push_back(opens_namespace ? std::string(match[1]) : "");
    } else if (c == '}' && !scopes.empty()) {
      scopes.pop_back();
    } else if (c == ';') {
      add(false);
    } else {
      declaration += c;
      continue;
    }
    declaration.clear();
  }
  return names;
}

}  // namespace

TEST_CASE("no name is defined in two files") {
  std::map<std::string, std::set<std::string>> files_of;
  for (const char* const layer : {"core", "scene", "kernels", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / layer)) {
      const fs::path file = fs::relative(entry.path(), SHEAF_SOURCE_DIR);
      // The importer and the launcher are programs of their own.
      const bool is_other_program = file.generic_string().starts_with("tools/importer/");
      if ((file.extension() != ".h" && file.extension() != ".cpp") || is_other_program) continue;
      std::stringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      for (const std::string& name : defined_names(text.str())) files_of[name].insert(file.generic_string());
    }
  }
  REQUIRE(files_of.size() > 1000);
  for (const auto& [name, files] : files_of) {
    if (files.size() == 1) continue;
    std::string list;
    for (const std::string& file : files) list += " " + file;
    FAIL_CHECK(name << " is defined in" << list);
  }
}

TEST_CASE("definitions at namespace scope are found") {
  CHECK(defined_names("namespace a { struct B { int c; }; class D final : public B {}; enum class E : int { kF }; }") ==
        std::set<std::string>{"a::B", "a::D", "a::E"});
  CHECK(defined_names("namespace a::b { template <class T> struct C : D<T> {}; template <class T> using E = C<T>; }") ==
        std::set<std::string>{"a::b::C", "a::b::E"});
  CHECK(defined_names("namespace a { constexpr int kB = 1; inline constexpr std::array<int, 2> kC = {1, 2}; }") ==
        std::set<std::string>{"a::kB", "a::kC"});
}

TEST_CASE("declarations, specializations, members and private names are no definitions of their own") {
  CHECK(
      defined_names("namespace a { struct B; template <> struct C<int> { struct D {}; }; void f(struct E); }").empty());
  CHECK(defined_names("namespace a { namespace { struct B {}; } void f() { struct C {}; } }").empty());
  CHECK(defined_names("namespace a { // struct B {};\n /* struct C {}; */ }\n#define D struct E {};\n").empty());
}

}  // namespace sheaf::test_one_definition
