// MTL files consist of lines with a keyword and arguments. Missing properties are distinguished from default values.
#include "scene/formats/mtl.h"

#include "scene/formats/mesh_io.h"
#include "scene/formats/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <string_view>

namespace sheaf {

namespace {

/// Removes the first word from `text` and returns it.
std::string_view take_word(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
  const std::string_view word = text.substr(0, end);
  text = trimmed(text.substr(end));
  return word;
}

std::optional<float> to_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, failure] = std::from_chars(word.data(), end, value);
  if (failure != std::errc{} || stop != end || !std::isfinite(static_cast<float>(value))) return std::nullopt;
  return static_cast<float>(value);
}

using Number = std::optional<float> MtlMaterial::*;
using Color = std::optional<Vec3f> MtlMaterial::*;
using Texture = std::optional<MtlTexture> MtlMaterial::*;
template <class Member> struct Keyword {
  std::string_view name;
  Member member;
};

constexpr std::array<Keyword<Number>, 9> kNumbers{{{"Ns", &MtlMaterial::shininess},
                                                   {"Ni", &MtlMaterial::ior},
                                                   {"d", &MtlMaterial::dissolve},
                                                   {"Pr", &MtlMaterial::roughness},
                                                   {"Pm", &MtlMaterial::metallic},
                                                   {"Ps", &MtlMaterial::sheen},
                                                   {"Pc", &MtlMaterial::clearcoat},
                                                   {"Pcr", &MtlMaterial::clearcoat_roughness},
                                                   {"aniso", &MtlMaterial::anisotropy}}};
constexpr std::array<Keyword<Color>, 5> kColors{{{"Kd", &MtlMaterial::diffuse},
                                                 {"Ks", &MtlMaterial::specular},
                                                 {"Ke", &MtlMaterial::emission},
                                                 {"Tf", &MtlMaterial::transmission},
                                                 {"Kt", &MtlMaterial::transmission}}};
constexpr std::array<Keyword<Texture>, 10> kTextures{{{"map_Kd", &MtlMaterial::map_diffuse},
                                                      {"map_Ks", &MtlMaterial::map_specular},
                                                      {"map_d", &MtlMaterial::map_dissolve},
                                                      {"map_Pr", &MtlMaterial::map_roughness},
                                                      {"map_Pm", &MtlMaterial::map_metallic},
                                                      {"map_Ps", &MtlMaterial::map_sheen},
                                                      {"map_Bump", &MtlMaterial::bump},
                                                      {"map_bump", &MtlMaterial::bump},
                                                      {"bump", &MtlMaterial::bump},
                                                      {"norm", &MtlMaterial::normal}}};
/// Keywords that do not matter to a path tracer, or that every exporter writes.
constexpr std::array<std::string_view, 5> kSilent{"Ka", "map_Ka", "sharpness", "map_aat", "anisor"};
/// Keywords that are known but not supported.
constexpr std::array<std::string_view, 8> kUnsupported{"map_Ke",   "map_Ns", "disp", "map_disp",
                                                       "map_Disp", "decal",  "refl", "map_refl"};

/// Options of textures.
constexpr std::array<std::string_view, 14> kOptions{"-s",          "-o",       "-clamp",  "-bm",    "-mm",
                                                    "-t",          "-blendu",  "-blendv", "-boost", "-cc",
                                                    "-colorspace", "-imfchan", "-texres", "-type"};
bool is_known_option(std::string_view word) {
  return std::find(kOptions.begin(), kOptions.end(), word) != kOptions.end();
}

template <class Keywords> auto find_keyword(const Keywords& keywords, std::string_view name) {
  return std::find_if(keywords.begin(), keywords.end(), [&](const auto& k) { return k.name == name; });
}

class MtlReader {
 public:
  MtlReader(std::string_view text, const std::filesystem::path& file)
      : text_(text), folder_(file.parent_path()), where_{file.string(), 0} {}

  MtlLibrary read() {
    while (!text_.empty()) {
      const std::size_t end = std::min(text_.find_first_of("\r\n"), text_.size());
      ++where_.line;
      read_line(trimmed(text_.substr(0, end)));
      const bool is_pair = text_.substr(end, 2) == "\r\n";
      text_.remove_prefix(std::min(end + (is_pair ? 2 : 1), text_.size()));
    }
    return std::move(library_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw SceneError(where_, message); }

  void note(const std::string& message) { library_.notes.push_back(SceneError(where_, message).what()); }

  void read_line(std::string_view line) {
    if (line.empty() || line.front() == '#') return;
    const std::string_view keyword = take_word(line);
    if (keyword == "newmtl") {
      if (line.empty()) fail("expected a material's name after 'newmtl'");
      library_.materials.push_back({});
      material().name = unquoted(line);
      material().where = where_;
      has_dissolve_ = false;
      return;
    }
    if (library_.materials.empty()) fail("expected 'newmtl' in front of the first property, found " + quoted(keyword));
    read_property(keyword, line);
  }

  void read_property(std::string_view keyword, std::string_view arguments) {
    const auto number = find_keyword(kNumbers, keyword);
    const auto color = find_keyword(kColors, keyword);
    const auto texture = find_keyword(kTextures, keyword);
    if (number != kNumbers.end()) {
      if (keyword == "d") {
        has_dissolve_ = true;
        if (arguments.starts_with("-halo")) take_word(arguments);
      }
      material().*(number->member) = take_number(keyword, arguments);
    } else if (keyword == "Tr") {
      const float transparency = take_number(keyword, arguments);
      if (!has_dissolve_) material().dissolve = 1 - transparency;
    } else if (keyword == "illum") {
      const float model = take_number(keyword, arguments);
      if (!(model >= 0 && model <= 10 && model == std::floor(model))) {
        fail(fmt::format("expected an illumination model from 0 to 10, found {}", model));
      }
      material().illum = static_cast<int>(model);
    } else if (color != kColors.end()) {
      read_color(keyword, arguments, material().*(color->member));
    } else if (texture != kTextures.end()) {
      read_texture(keyword, arguments, material().*(texture->member));
    } else if (std::find(kSilent.begin(), kSilent.end(), keyword) == kSilent.end()) {
      note_unused(keyword);
    }
  }

  float take_number(std::string_view keyword, std::string_view& arguments) const {
    const std::string_view word = take_word(arguments);
    if (const auto number = to_number(word)) return *number;
    fail(fmt::format("expected a number after '{}', found {}", keyword, quoted(word)));
  }

  /// A single number applies to all three channels.
  void read_color(std::string_view keyword, std::string_view arguments, std::optional<Vec3f>& color) {
    if (arguments.starts_with("spectral") || arguments.starts_with("xyz")) {
      note(fmt::format("'{}' by 'spectral' or 'xyz' is not supported: ignored", keyword));
      return;
    }
    const float r = take_number(keyword, arguments);
    color = Vec3f{r, r, r};
    if (arguments.empty() || arguments.front() == '#') return;
    color->y = take_number(keyword, arguments);
    color->z = take_number(keyword, arguments);
  }

  /// Options may precede or follow the image name. The name may be quoted, and may contain blanks. An unquoted name
  /// extends to the end of the line if such a file exists, else to the first option or comment.
  void read_texture(std::string_view keyword, std::string_view arguments, std::optional<MtlTexture>& slot) {
    MtlTexture texture;
    texture.where = where_;
    while (is_option(arguments)) read_option(keyword, arguments, texture, false);
    const std::string_view name = take_image_name(arguments);
    if (name.empty()) fail(fmt::format("expected the name of an image after '{}'", keyword));
    while (is_option(arguments)) read_option(keyword, arguments, texture, true);
    if (!arguments.empty() && arguments.front() != '#')
      fail("expected nothing or an option after the name of an image, found " + quoted(arguments));
    texture.file = find_image(name);
    slot = std::move(texture);
  }

  /// Whether the text starts with a minus and a letter. Names may be a single minus, or start with a minus and a digit.
  static bool is_option(std::string_view text) {
    return text.size() > 1 && text[0] == '-' &&
           ((text[1] >= 'a' && text[1] <= 'z') || (text[1] >= 'A' && text[1] <= 'Z'));
  }

  std::string_view take_image_name(std::string_view& arguments) const {
    // Take a quoted name
    if (arguments.starts_with('"')) {
      const std::size_t end = arguments.find('"', 1);
      if (end == arguments.npos) fail("a name has no closing quotation mark");
      const std::string_view name = arguments.substr(1, end - 1);
      arguments = trimmed(arguments.substr(end + 1));
      return name;
    }
    // Take all words up to an option or comment, unless the whole text names a file
    std::size_t end = arguments.size();
    std::error_code failure;
    if (!std::filesystem::exists(find_image(arguments), failure))
      for (std::size_t blank = arguments.find_first_of(" \t"); blank != arguments.npos;) {
        const std::size_t word = arguments.find_first_not_of(" \t", blank);  // exists, because the text is trimmed
        const std::size_t next = std::min(arguments.find_first_of(" \t", word), arguments.size());
        if (arguments[word] == '#' || is_known_option(arguments.substr(word, next - word))) {
          end = blank;
          break;
        }
        blank = arguments.find_first_of(" \t", word);
      }
    const std::string_view name = trimmed(arguments.substr(0, end));
    arguments = trimmed(arguments.substr(end));
    return name;
  }

  /// `behind`: the option follows the image name.
  void read_option(std::string_view keyword, std::string_view& arguments, MtlTexture& texture, bool behind) {
    const std::string_view option = take_word(arguments);
    if (option == "-s") {
      texture.scale = take_numbers(keyword, arguments, {1, 1}, behind);
    } else if (option == "-o") {
      texture.offset = take_numbers(keyword, arguments, {0, 0}, behind);
    } else if (option == "-clamp") {
      texture.clamp = take_word(arguments) == "on";
    } else if (option == "-bm") {
      texture.bump_multiplier = take_number(keyword, arguments);
    } else if (option == "-mm") {
      take_number(keyword, arguments);
      take_number(keyword, arguments);
      note_unused(option);
    } else if (option == "-t") {
      take_numbers(keyword, arguments, {0, 0}, behind);
      note_unused(option);
    } else if (is_known_option(option)) {
      take_word(arguments);
    } else {
      fail(fmt::format("unknown option {} of '{}'{}", quoted(option), keyword,
                       did_you_mean(option, {kOptions.begin(), kOptions.end()})));
    }
  }

  /// Reads one to three numbers and returns the first two; missing ones come from `default_value`. Unless `last`, the
  /// final word is the image name, not a number.
  Vec2f take_numbers(std::string_view keyword, std::string_view& arguments, Vec2f default_value, bool last) const {
    Vec2f taken{take_number(keyword, arguments), default_value.y};
    for (int i = 1; i < 3; ++i) {
      std::string_view rest = arguments;
      const auto next = to_number(take_word(rest));
      if (!next || (rest.empty() && !last)) break;
      arguments = rest;
      if (i == 1) taken.y = *next;
    }
    return taken;
  }

  /// Returns the path of an image. Also searches next to the library, because paths may come from another computer.
  std::filesystem::path find_image(std::string_view name) const {
    std::string portable(name);
    std::replace(portable.begin(), portable.end(), '\\', '/');
    std::filesystem::path file = folder_ / portable;
    std::error_code failure;
    if (std::filesystem::exists(file, failure)) return file;
    const std::filesystem::path beside = folder_ / std::filesystem::path(portable).filename();
    return std::filesystem::exists(beside, failure) ? beside : file;
  }

  /// Adds a note, once per keyword or option.
  void note_unused(std::string_view keyword) {
    if (!noted_.insert(std::string(keyword.substr(0, 64))).second) return;
    const bool is_known =
        keyword.front() == '-' || std::find(kUnsupported.begin(), kUnsupported.end(), keyword) != kUnsupported.end();
    if (is_known) {
      note(quoted(keyword) + " is not supported: ignored");
      return;
    }
    std::vector<std::string> names{"newmtl", "illum", "Tr"};
    for (const auto& known : kNumbers) names.emplace_back(known.name);
    for (const auto& known : kColors) names.emplace_back(known.name);
    for (const auto& known : kTextures) names.emplace_back(known.name);
    note(fmt::format("unknown keyword {} ignored{}", quoted(keyword), did_you_mean(keyword, names)));
  }

  MtlMaterial& material() { return library_.materials.back(); }

  std::string_view text_;
  std::filesystem::path folder_;
  SourceLocation where_;
  MtlLibrary library_;
  std::set<std::string> noted_;
  bool has_dissolve_ = false;  ///< 'd' takes precedence over 'Tr'
};

}  // namespace

MtlLibrary read_mtl(const std::filesystem::path& file) {
  const std::string text = read_mesh_text(file, "MTL file");
  return MtlReader(text, file).read();
}

}  // namespace sheaf
