// The parameters that readers of XML scenes query, against the tables in docs/scene-format/: every plugin has a
// section, every parameter a row with the default of the code, and every row is a parameter.
#include "scene/dialects/read_scene.h"
#include "scene/xml/properties.h"
#include "scene/xml/query_recorder.h"
#include "tests/support/files/format_docs.h"
#include "tests/support/plugin_samples.h"

#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <set>
#include <sstream>

namespace sheaf::test_documented_parameters {

namespace {

using namespace sheaf::test;

/// What readers know about one parameter of a plugin.
struct Queried {
  std::string name;  ///< as spelled in the code
  std::set<std::string> types, defaults;
};
/// Parameters by spelling_key().
using Parameters = std::map<std::string, Queried>;

/// A plugin in one dialect, such as {kNori, "bsdf", "diffuse"}.
struct PluginKey {
  Dialect dialect;
  std::string element, name;
  // NOLINTNEXTLINE(modernize-use-nullptr): a false positive of clang-tidy 14
  auto operator<=>(const PluginKey&) const = default;
  std::string text() const { return element + " '" + name + "' (" + dialect_name(dialect) + ")"; }
};

constexpr Dialect kDialects[] = {Dialect::kMitsuba, Dialect::kMitsuba06, Dialect::kNori};

/// Elements with plugins, and the pages that document these.
const std::map<std::string, std::vector<std::string>> kPages = {
    {"bsdf", {"bsdfs"}},
    {"camera", {"nori"}},
    {"emitter", {"emitters"}},
    {"film", {"films"}},
    {"integrator", {"integrators"}},
    {"medium", {"media"}},
    {"mesh", {"shapes"}},
    {"phase", {"phase-functions"}},
    {"rfilter", {"films"}},
    {"sampler", {"samplers"}},
    {"sensor", {"sensors"}},
    {"shape", {"shapes"}},
    {"spectrum", {"spectra"}},
    {"subsurface", {"media"}},
    {"texture", {"textures", "spectra"}},
    {"volume", {"media"}},
};

/// Content that plugins require and no snippet of the documentation has, or that selects another branch of a
/// reader. The key is the name of the plugin.
const std::multimap<std::string, std::string> kContents = {
    {"adaptive", "<integrator type='path'/>"},
    {"aov", "<integrator type='path'/>"},
    {"blackbody", "<float name='temperature' value='5000'/>"},
    {"blend", "<phase type='hg'/><phase type='hg'/>"},
    {"constantvolume", "<float name='value' value='1'/>"},
    {"constvolume", "<float name='value' value='1'/>"},
    {"deformable", "<string name='times' value='0'/><shape type='cube'/>"},
    {"ellipsoidsmesh", "<string name='filename' value='splats.ply'/>"},
    {"heterogeneous",
     "<volume name='density' type='constvolume'><float name='value' value='1'/></volume>"
     "<string name='method' value='simpson'/>"},
    {"illuminant", "<string name='name' value='e'/>"},
    {"imagetexture", "<string name='filename' value='wood.png'/>"},
    {"instance", "<shape type='shapegroup'><shape type='sphere'/></shape>"},
    {"instance", "<mesh type='shapegroup'><mesh type='sphere'/></mesh>"},
    {"irregular", "<string name='wavelengths' value='400, 700'/><string name='values' value='0, 1'/>"},
    {"irrcache", "<integrator type='path'/>"},
    {"moment", "<integrator type='path'/>"},
    {"multichannel", "<integrator type='path'/>"},
    {"nanovdb", "<string name='filename' value='cloud.nvdb'/>"},
    {"normaltexture", "<string name='filename' value='wood.png'/>"},
    {"png_texture", "<string name='filename' value='wood.png'/>"},
    {"rawconstant", "<float name='value' value='0.3'/>"},
    {"rawconstant", "<vector name='value' value='1, 2, 3'/>"},
    {"regular", "<string name='values' value='0, 1'/>"},
    {"srgb", "<rgb name='color' value='0.3'/>"},
    {"stokes", "<integrator type='path'/>"},
    {"vol", "<string name='filename' value='smoke.vol'/>"},
    {"volcache", "<volume type='constvolume'><float name='value' value='1'/></volume>"},
};

/// The plugins of all dialects with the parameters that their readers query.
class KnownParameters {
 public:
  explicit KnownParameters(const std::vector<DocumentedSection>& sections) {
    for (const Dialect dialect : kDialects) {
      find_plugins(dialect);
      for (const DocumentedSection& section : sections)
        for (const std::string& snippet : section.snippets) {
          const bool is_scene = first_tag(snippet) == "scene";
          if (!is_scene || dialect == Dialect::kNori) read_all(dialect, snippet);
        }
    }
    const std::map<PluginKey, Parameters> plugins = plugins_;
    for (const auto& [plugin, parameters] : plugins) read_samples(plugin);
  }

  const std::map<PluginKey, Parameters>& plugins() const { return plugins_; }
  bool is_finished(const PluginKey& plugin) const { return finished_.count(plugin) != 0; }
  const std::string& error_of(const PluginKey& plugin) { return errors_[plugin]; }

 private:
  /// Takes the names of plugins from the errors about unknown ones.
  void find_plugins(Dialect dialect) {
    for (const auto& [element, pages] : kPages) {
      QueryRecorder recorder;
      for (const std::string& scene : scenes_around(dialect, element_of({dialect, element, "?"}, ""))) read(scene);
      const auto known = recorder.plugins.find(element);
      if (known == recorder.plugins.end()) continue;
      for (const std::string& name : known->second) plugins_[{dialect, element, name}];
    }
    for (const char* name : {"shapegroup", "instance"})
      plugins_[{dialect, dialect == Dialect::kNori ? "mesh" : "shape", name}];
  }

  /// The smallest element of a plugin with some content.
  static std::string element_of(const PluginKey& plugin, const std::string& content) {
    std::string name;
    if (plugin.element == "texture" || plugin.element == "spectrum") name = " name='reflectance'";
    if (plugin.element == "volume") name = " name='sigma_t'";
    return "<" + plugin.element + name + " type='" + plugin.name + "'>" + content + "</" + plugin.element + ">";
  }

  void read_samples(const PluginKey& plugin) {
    const auto [begin, end] = kContents.equal_range(plugin.name);
    std::vector<std::string> contents = {""};
    for (auto at = begin; at != end; ++at) contents.push_back(at->second);
    for (const std::string& content : contents) errors_[plugin] = read_all(plugin.dialect, element_of(plugin, content));
  }

  /// Reads the elements in every place of a scene, and records the queries. Returns the last error.
  std::string read_all(Dialect dialect, const std::string& elements) {
    std::string error;
    for (const std::string& scene : scenes_around(dialect, elements)) {
      QueryRecorder recorder;
      error = read(scene);
      for (const ValueQuery& query : recorder.queries) {
        const std::optional<PluginKey> plugin = key_of(dialect, query.object);
        if (!plugin) continue;
        Queried& known = plugins_[*plugin][spelling_key(query.name == "phasefunction" ? "phase" : query.name)];
        known.name = query.name;
        if (!query.type.empty()) known.types.insert(query.type);
        if (!query.default_value.empty()) known.defaults.insert(query.default_value);
      }
      for (const std::string& title : recorder.finished)
        if (const std::optional<PluginKey> plugin = key_of(dialect, title)) finished_.insert(*plugin);
    }
    return error;
  }

  /// Reads a scene. Returns the error message, or an empty text.
  static std::string read(const std::string& scene) {
    const TemporaryFolder folder;
    write_named_files(folder, scene);
    write_bytes(folder / "scene.xml", scene);
    try {
      read_scene(folder / "scene.xml");
    } catch (const Error& error) { return error.what(); }
    return {};
  }

  /// The plugin with the title "bsdf 'diffuse'", if it is known.
  std::optional<PluginKey> key_of(Dialect dialect, const std::string& title) const {
    const std::size_t quote = title.find(" '");
    if (quote == std::string::npos) return std::nullopt;
    std::string element = title.substr(0, quote);
    if (element == "phasefunction") element = "phase";
    const PluginKey key{dialect, element, title.substr(quote + 2, title.size() - quote - 3)};
    return plugins_.count(key) != 0 ? std::optional<PluginKey>(key) : std::nullopt;
  }

  std::map<PluginKey, Parameters> plugins_;
  std::set<PluginKey> finished_;
  std::map<PluginKey, std::string> errors_;
};

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

/// The key by which names in tables and in code are compared. Indices in brackets, as of "label[x, y]", do not count.
std::string key_of_name(const std::string& name) {
  const std::size_t bracket = name.find('[');
  return spelling_key(bracket == std::string::npos ? name : name.substr(0, bracket + 1));
}

/// The sections that document plugins.
class Documentation {
 public:
  explicit Documentation(const std::vector<DocumentedSection>& sections) : sections_(sections) {}

  /// The sections that name the plugin in their headings, or else in their text.
  std::vector<const DocumentedSection*> own_sections(const PluginKey& plugin) const {
    const std::vector<std::string>& pages = kPages.at(plugin.element);
    std::vector<const DocumentedSection*> found, mentions;
    for (const bool nori : {true, false})
      for (const DocumentedSection& section : sections_) {
        const bool fits =
            nori ? section.page == "nori" && plugin.dialect == Dialect::kNori : contains(pages, section.page);
        if (!fits) continue;
        if (contains(section.names, plugin.name)) found.push_back(&section);
        if (section.text.find("`" + plugin.name + "`") != std::string::npos) mentions.push_back(&section);
      }
    if (!found.empty()) return found;
    // Names of the other dialect
    for (const DocumentedSection& section : sections_)
      if (section.page == "nori" && contains(section.names, plugin.name)) found.push_back(&section);
    return !found.empty() ? found : mentions;
  }

  /// All sections with parameters of the plugin, the most special ones first.
  std::vector<const DocumentedSection*> sections_for(const PluginKey& plugin) const {
    std::vector<const DocumentedSection*> found = own_sections(plugin);
    // In the Nori dialect, those of its own plugins and elements come first
    const auto common =
        std::stable_partition(found.begin(), found.end(), [](const auto* s) { return s->page == "nori"; });
    std::vector<const DocumentedSection*> elements;
    for (const DocumentedSection& section : sections_)
      if (section.page == "nori" && plugin.dialect == Dialect::kNori && contains(section.names, plugin.element))
        elements.push_back(&section);
    found.insert(common, elements.begin(), elements.end());
    // Sections of which they have the parameters
    for (std::size_t i = 0; i < found.size() && found.size() < 100; ++i)
      for (const std::string& name : inherited_by(*found[i]))
        for (const DocumentedSection& section : sections_)
          if (contains(section.names, name) && std::find(found.begin(), found.end(), &section) == found.end())
            found.push_back(&section);
    // Sections about all plugins of the page
    for (const DocumentedSection& section : sections_)
      if (section.names.empty() && contains(kPages.at(plugin.element), section.page)) found.push_back(&section);
    return found;
  }

  /// The rows of a parameter, the most special one first.
  std::vector<const DocumentedParameter*> rows_of(const PluginKey& plugin, const std::string& key) const {
    std::vector<const DocumentedParameter*> rows;
    for (const DocumentedSection* section : sections_for(plugin))
      for (const DocumentedParameter& parameter : section->parameters)
        for (const std::string& name : parameter.names)
          if (key_of_name(name) == key) rows.push_back(&parameter);
    return rows;
  }

 private:
  const std::vector<DocumentedSection>& sections_;
};

/// The value of a number such as "10,000", "-1" or "1/3"; NaN for other texts.
double number_of(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), ','), text.end());
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str()) return NAN;
  if (*end != '/') return *end == 0 ? value : NAN;
  const double divisor = std::strtod(end + 1, &end);
  return *end == 0 ? value / divisor : NAN;
}

/// Whether a default value in the documentation is that of the code.
bool is_same_value(const std::string& documented, const std::string& code) {
  std::string text = documented;
  std::erase_if(text, [](char c) { return c == '`' || c == '"'; });
  if (text == code || (text == "unlimited" && code == "inf")) return true;
  // Compare vectors by component
  const bool is_vector = text.starts_with("(") && text.ends_with(")") && code.starts_with("(") && code.ends_with(")");
  const auto numbers = [&](const std::string& list) {
    return is_vector ? parts_of(list.substr(1, list.size() - 2)) : std::vector{list};
  };
  const std::vector<std::string> a = numbers(text), b = numbers(code);
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = number_of(a[i]), y = number_of(b[i]);
    if (!(std::fabs(x - y) <= 1e-6 * std::fabs(y))) return false;
  }
  return true;
}

/// Whether words such as "Nori", "path_ris" or "Mitsuba prb..." all fit a plugin.
bool is_meant(const PluginKey& plugin, const std::string& words) {
  std::istringstream stream(words);
  for (std::string word; stream >> word;) {
    const bool is_prefix = word.ends_with("...") && plugin.name.starts_with(word.substr(0, word.size() - 3));
    const bool is_mitsuba = word == "Mitsuba" && plugin.dialect != Dialect::kNori;
    if (!is_prefix && !is_mitsuba && word != plugin.name && word != dialect_name(plugin.dialect)) return false;
  }
  return true;
}

/// The default of a plugin in a cell such as "4 (Nori: 1)" or "1 (`path_ris`, `direct_ris`: 8)".
std::string default_for(const PluginKey& plugin, const std::string& cell) {
  static const std::regex kVariant("^(.*?) ?\\(([^():]+): ([^()]+)\\)$");
  std::smatch match;
  if (!std::regex_match(cell, match, kVariant)) return cell;
  std::string dialects = match[2].str();
  std::erase(dialects, '`');
  const std::vector<std::string> keys = parts_of(dialects);
  const bool applies =
      std::any_of(keys.begin(), keys.end(), [&](const std::string& key) { return is_meant(plugin, key); });
  return applies ? match[3].str() : match[1].str();
}

/// Defaults that are not compared: words, or values that the code does not pass to its readers of parameters. Numbers
/// are compared nevertheless if the code does.
struct NotCompared {
  const char *parameter, *text;
};
constexpr NotCompared kNotCompared[] = {
    {"beam_width", "3/4 of `cutoff_angle`"},
    {"candidates", "see below"},
    {"crop_width", "the rest of the film"},
    {"crop_height", "the rest of the film"},
    {"emission", "0"},  // MediumDescription::emission is absent
    {"end_year", "`start_year` + 1"},
    {"extIOR", "1"},  // of presets
    {"falloffStart", "`totalWidth` - 5"},
    {"finalGather", "true if `numGatherRays` > 0"},
    {"fitToShape", "true without a `toWorld`"},
    {"fit_to_shape", "true without a `to_world`"},
    {"focal_length", "\"50mm\""},  // a string or a number
    {"fov", "from `focal_length`"},
    {"grid_name", "the first"},
    {"intIOR", "the preset's"},
    {"maxPasses", "samples per pixel"},
    {"medium", "found automatically"},
    {"rr_depth", "see below"},
    {"rr_depth", "5"},  // kDefaultRouletteDepth
    {"sigma_a", "0"},   // if `sigma_s` is given
    {"sigma_s", "0"},
    {"sigma_t", "1"},  // not in `heterogeneous` of 0.6
    {"step_size", "1/100 of the medium's diagonal"},
    {"step_size", "as of [`marching`](integrators.md#medium-estimators)"},
    {"weight", "0.5"},  // BlendPhaseDescription::weight
};

/// Elements whose default plugins are not compared.
const std::set<std::string> kObjects = {"bsdf", "film", "phase", "rfilter", "sampler"};

/// Nested elements that readers query without being parameters: plugin and element.
const std::set<std::pair<std::string, std::string>> kInternal = {
    {"constantvolume", "volume"}, {"constvolume", "volume"}, {"instance", "mesh"}, {"instance", "shape"}};

/// Types in tables that are narrower than what the readers ask for.
const std::set<std::string> kNarrowTypes = {"float or `constvolume`", "shapegroup"};

/// Whether the type in a table is one that the code asks for.
bool is_same_type(std::string type, const std::set<std::string>& known) {
  if (kNarrowTypes.count(type) != 0) return true;
  if (type == "point") type = "vector";
  if (known.count(type) != 0) return true;
  const std::size_t either = type.find(" or ");
  if (either == std::string::npos) return false;
  return is_same_type(type.substr(0, either), known) && is_same_type(type.substr(either + 4), known);
}

/// Compares one parameter of a plugin with its row. Returns what is wrong, or nothing.
std::string difference(const PluginKey& plugin, const Parameters& parameters, const DocumentedParameter& row) {
  // Alternative names share types and defaults
  Queried queried;
  for (const std::string& name : row.names)
    if (const auto found = parameters.find(key_of_name(name)); found != parameters.end()) {
      queried.types.insert(found->second.types.begin(), found->second.types.end());
      queried.defaults.insert(found->second.defaults.begin(), found->second.defaults.end());
    }
  const bool is_ignored = queried.types.count("ignored") != 0;
  if (is_ignored && queried.types.size() == 1)
    return row.meaning.find("ignored") != std::string::npos ? "" : "is ignored by the code";
  std::string code;
  for (const std::string& value : queried.defaults) code += (code.empty() ? "" : " or ") + value;
  if (row.type.empty()) return {};
  if (!queried.types.empty() && !is_same_type(row.type, queried.types)) {
    std::string types;
    for (const std::string& type : queried.types) types += (types.empty() ? "" : ", ") + type;
    return "has the type '" + row.type + "', but the code has: " + types;
  }
  const std::string documented = default_for(plugin, row.default_value);
  if (documented == "required") return code.empty() || code == "required" ? "" : "is optional, its default is " + code;
  // Defaults that are not literal: other parameters, alternatives, objects and words
  const bool is_number = !std::isnan(number_of(documented));
  const auto other = parameters.find(key_of_name(code_in(documented).empty() ? "" : code_in(documented)[0]));
  const bool is_alternative = documented.empty() && row.meaning.find("instead") != std::string::npos;
  const bool is_object = documented.starts_with("`") && kObjects.count(row.type) != 0;
  const bool is_not_compared =
      std::any_of(std::begin(kNotCompared), std::end(kNotCompared), [&](const NotCompared& each) {
        return contains(row.names, each.parameter) && documented == each.text && (code.empty() || !is_number);
      });
  if (is_alternative || is_object || is_not_compared) return {};
  const auto is_default = [&](const std::string& value) {
    const bool as_other = other != parameters.end() && other->second.defaults.count(value) != 0;
    return as_other || is_same_value(documented, value);
  };
  if (std::any_of(queried.defaults.begin(), queried.defaults.end(), is_default)) return {};
  if (code.empty() && documented.empty()) return {};
  return "has the default '" + documented + "', but the code has '" + code + "'";
}

/// Whether the headings of a section name plugins or, in the Nori dialect, elements.
bool is_about_plugins(const DocumentedSection& section) {
  return section.page == "nori" || std::any_of(kPages.begin(), kPages.end(),
                                               [&](const auto& entry) { return contains(entry.second, section.page); });
}

bool is_plugin(const std::map<PluginKey, Parameters>& plugins, const std::string& page, const std::string& name) {
  return std::any_of(plugins.begin(), plugins.end(), [&](const auto& entry) {
    const PluginKey& plugin = entry.first;
    const bool is_nori = page == "nori" && plugin.dialect == Dialect::kNori;
    return (is_nori && plugin.element == name) ||
           (plugin.name == name && (is_nori || contains(kPages.at(plugin.element), page)));
  });
}

bool is_documented(const std::vector<DocumentedSection>& sections, const NotCompared& entry) {
  for (const DocumentedSection& section : sections)
    for (const DocumentedParameter& parameter : section.parameters)
      if (contains(parameter.names, entry.parameter) && parameter.default_value == entry.text) return true;
  return false;
}

}  // namespace

TEST_CASE("the tables in docs/scene-format list every parameter with its default") {
  const std::vector<DocumentedSection> sections = format_sections();
  KnownParameters known(sections);
  const Documentation documentation(sections);
  std::set<std::string> failures;
  std::set<const DocumentedParameter*> asked;
  for (const auto& [plugin, parameters] : known.plugins()) {
    if (!known.is_finished(plugin)) failures.insert(plugin.text() + " is not tested: " + known.error_of(plugin));
    if (documentation.own_sections(plugin).empty()) failures.insert(plugin.text() + " has no section");
    for (const auto& [key, queried] : parameters) {
      const auto rows = documentation.rows_of(plugin, key);
      asked.insert(rows.begin(), rows.end());
      if (rows.empty() && kInternal.count({plugin.name, queried.name}) == 0)
        failures.insert(plugin.text() + " has the parameter '" + queried.name + "', which is not documented");
      if (rows.empty()) continue;
      // A row without a type refers to a less special one
      const auto row = std::find_if(rows.begin(), rows.end(), [](const auto* each) { return !each->type.empty(); });
      const DocumentedParameter& parameter = row != rows.end() ? **row : *rows[0];
      if (const std::string what = difference(plugin, parameters, parameter); !what.empty())
        failures.insert(parameter.location + ": '" + queried.name + "' of " + plugin.text() + " " + what);
    }
  }
  for (const DocumentedSection& section : sections)
    for (const DocumentedParameter& parameter : section.parameters)
      if (asked.count(&parameter) == 0)
        failures.insert(parameter.location + ": no reader knows the parameter '" + parameter.names[0] + "'");
  for (const DocumentedSection& section : sections)
    for (const std::string& name : section.names)
      if (is_about_plugins(section) && !is_plugin(known.plugins(), section.page, name))
        failures.insert(section.location + ": there is no plugin '" + name + "'");
  for (const NotCompared& entry : kNotCompared)
    if (!is_documented(sections, entry))
      failures.insert(std::string("no row of '") + entry.parameter + "' has the default '" + entry.text + "'");
  for (const std::string& failure : failures) FAIL_CHECK(failure);
  CHECK(failures.empty());
}

}  // namespace sheaf::test_documented_parameters
