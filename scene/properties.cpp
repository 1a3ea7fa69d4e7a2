// Typed access to the properties of an object.
#include "scene/properties.h"

#include "scene/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

const std::vector<std::string> kPropertyTags = {"float",     "integer",   "boolean", "string", "point",
                                                "vector",    "rgb",       "srgb",    "color",  "spectrum",
                                                "blackbody", "transform", "texture"};
const std::vector<std::string> kObjectTags = {"sensor",     "camera", "film",   "sampler",    "rfilter",
                                              "integrator", "shape",  "mesh",   "bsdf",       "emitter",
                                              "medium",     "phase",  "volume", "subsurface", "test"};
constexpr std::size_t kMaxNesting = 100;

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }

std::string range_text(NumberRange range) {
  auto shown = [](double v) {
    std::string text = std::to_string(v);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
  };
  const bool bounded = range.high < std::numeric_limits<double>::infinity();
  if (!bounded && range.low == 0) return range.open ? "a positive number" : "no negative number";
  if (!bounded) return "a number of at least " + shown(range.low);
  return "a number " + std::string(range.open ? "between " : "from ") + shown(range.low) +
         (range.open ? " and " : " to ") + shown(range.high);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// A spectrum given as a plugin: <spectrum type="...">.
SpectrumDescription read_spectrum_plugin(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  auto list = [&](const char* name) {
    const std::optional<std::string> text = p.find_string(name);
    if (!text) p.fail("needs the string '" + std::string(name) + "'");
    return parse_floats(*text, p.where(), name);
  };
  SpectrumDescription result;
  if (p.type() == "uniform") {
    result = SpectrumDescription::constant(p.number("value", 1));
    p.accept({"wavelength_min", "wavelength_max"});
  } else if (p.type() == "d65") {
    result = SpectrumDescription::constant(p.number("scale", 1, kNotNegative));
  } else if (p.type() == "srgb") {
    const std::optional<SpectrumDescription> color = p.find_spectrum("color", SpectrumRole::kIor);
    if (!color) p.fail("needs the property 'color'");
    result = *color;
  } else if (p.type() == "blackbody") {
    const std::optional<float> temperature = p.find_number("temperature", kPositive);
    if (!temperature) p.fail("needs the float 'temperature' (kelvin)");
    result.value = SpectrumDescription::Blackbody{*temperature, p.number("scale", 1, kNotNegative)};
    p.accept({"wavelength_min", "wavelength_max"});
  } else if (p.type() == "irregular") {
    result.value = SpectrumDescription::Table{list("wavelengths"), list("values")};
  } else if (p.type() == "regular") {
    SpectrumDescription::Table table{{}, list("values")};
    const float low = p.number("wavelength_min", 360, kPositive), high = p.number("wavelength_max", 830, kPositive);
    const std::size_t n = table.values.size();
    for (std::size_t i = 0; i < n; ++i) {
      const float t = n > 1 ? static_cast<float>(i) / static_cast<float>(n - 1) : 0.0f;
      table.wavelengths.push_back((1 - t) * low + t * high);
    }
    result.value = std::move(table);
  } else {
    p.fail_plugin({"blackbody", "d65", "irregular", "regular", "srgb", "uniform"});
  }
  p.finish();
  if (const auto* table = std::get_if<SpectrumDescription::Table>(&result.value)) check_table(*table, element.where);
  return result;
}

SpectrumDescription read_blackbody(const XmlElement& element) {
  element.expect_attributes({"name", "id", "temperature", "scale"});
  std::string_view kelvin = element.attribute("temperature");
  if (!kelvin.empty() && (kelvin.back() == 'K' || kelvin.back() == 'k')) kelvin.remove_suffix(1);
  SpectrumDescription::Blackbody result;
  result.temperature = parse_float(kelvin, element.where, "temperature");
  if (const std::string* scale = element.find_attribute("scale"))
    result.scale = parse_float(*scale, element.where, "scale");
  if (!(result.temperature > 0)) throw SceneError(element.where, "the temperature of <blackbody> must be positive");
  if (!(result.scale >= 0)) throw SceneError(element.where, "the scale of <blackbody> must not be negative");
  return {result};
}

SpectrumDescription read_spectrum(const XmlElement& element, ReadContext& context) {
  if (element.name == "blackbody") return read_blackbody(element);
  if (element.name == "spectrum" && element.find_attribute("type") != nullptr)
    return read_spectrum_plugin(element, context);
  element.expect_attributes({"name", "id", "value", element.name == "spectrum" ? "filename" : "value"});
  const std::string* file = element.find_attribute("filename");
  if (file != nullptr) {
    if (element.find_attribute("value") != nullptr)
      throw SceneError(element.where, "<spectrum> has both 'value' and 'filename'");
    return {read_spd(context.scene.find_file(*file, element.where))};
  }
  const std::string& text = element.attribute("value");
  if (element.name == "spectrum") return parse_spectrum_text(text, element.where);
  if (element.name == "rgb" || element.name == "color")
    return {SpectrumDescription::Rgb{parse_rgb(text, element.where)}};
  if (element.name == "srgb") return {SpectrumDescription::Rgb{parse_srgb(text, element.where)}};
  return SpectrumDescription::constant(parse_float(text, element.where, element.name));
}

/// Mitsuba takes a constant <spectrum> of an emitter as the same power at every wavelength, which is not white:
/// constants written as rgb or float, and `d65`, are relative to D65.
void make_equal_energy(const XmlElement& element, SpectrumDescription& spectrum) {
  const auto* constant = std::get_if<SpectrumDescription::Constant>(&spectrum.value);
  const std::string* type = element.find_attribute("type");
  if (constant == nullptr || (type != nullptr && *type != "uniform")) return;
  spectrum.value = SpectrumDescription::Table{{360, 830}, {constant->value, constant->value}};
}

}  // namespace

void ReadContext::note(const SourceLocation& where, const std::string& message) {
  description.notes.push_back(where.file + ":" + std::to_string(where.line) + ": " + message);
}

std::string snake_case(std::string_view name) {
  std::string result;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (!is_upper(c)) {
      result += c;
      continue;
    }
    const bool after_word = i > 0 && !is_upper(name[i - 1]) && name[i - 1] != '_';
    const bool begins_word =
        i > 0 && is_upper(name[i - 1]) && i + 1 < name.size() && name[i + 1] >= 'a' && name[i + 1] <= 'z';
    if (after_word || begins_word) result += '_';
    result += static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

Properties::Properties(const XmlElement& object, ReadContext& context) : object_(object), context_(context) {
  object.expect_attributes({"type", "id", "name", "version"});
  type_ = object.attribute("type");
  for (const XmlElement& child : object.children) add(child);
  if (context.open.count(&object) != 0) throw SceneError(object.where, title() + " refers to itself");
  if (context.open.size() >= kMaxNesting) throw SceneError(object.where, "objects refer to each other too deeply");
  context.open.insert(&object);
}

Properties::~Properties() { context_.open.erase(&object_); }

void Properties::add(const XmlElement& child) {
  const XmlElement* target = &child;
  if (child.name == "ref") {
    child.expect_attributes({"id", "name"});
    target = &context_.scene.find(child.attribute("id"), child.where);
  }
  const std::string* name = child.find_attribute("name");
  if (contains(kObjectTags, target->name)) {
    entries_.push_back({"", name != nullptr ? *name : "", &child, target});
    return;
  }
  if (!contains(kPropertyTags, target->name)) {
    std::vector<std::string> known = kPropertyTags;
    known.insert(known.end(), kObjectTags.begin(), kObjectTags.end());
    known.push_back("ref");
    throw SceneError(child.where,
                     "unknown element <" + target->name + "> in " + title() + did_you_mean(target->name, known));
  }
  if (name == nullptr || name->empty())
    throw SceneError(child.where, "<" + child.name + "> in " + title() + " needs an attribute 'name'");
  const std::string key = snake_case(*name);
  for (const Entry& entry : entries_)
    if (entry.key == key) throw SceneError(child.where, "property " + in_quotes(*name) + " is given twice");
  entries_.push_back({key, *name, &child, target});
}

Properties::Entry* Properties::find(const char* name) {
  const std::string key = snake_case(name);
  for (Entry& entry : entries_)
    if (!entry.key.empty() && entry.key == key) return &entry;
  return nullptr;
}

Properties::Entry* Properties::use(const char* name) {
  asked_.emplace_back(name);
  Entry* entry = find(name);
  if (entry != nullptr) entry->used = true;
  return entry;
}

const std::string* Properties::value(const char* name, std::initializer_list<const char*> types) {
  const Entry* entry = use(name);
  if (entry == nullptr) return nullptr;
  const bool fits = std::any_of(types.begin(), types.end(), [&](const char* t) { return entry->target->name == t; });
  if (!fits) fail_type(*entry, *types.begin());
  entry->target->expect_attributes({"name", "id", "value"});
  if (!entry->target->children.empty())
    throw SceneError(entry->target->where, "<" + entry->target->name + "> holds no elements");
  return &entry->target->attribute("value");
}

bool Properties::has(const char* name) {
  asked_.emplace_back(name);
  return find(name) != nullptr;
}

bool Properties::is_string(const char* name) {
  const Entry* entry = find(name);
  return entry != nullptr && entry->target->name == "string";
}

std::optional<float> Properties::find_number(const char* name, NumberRange range) {
  const std::string* text = value(name, {"float", "integer"});
  if (text == nullptr) return std::nullopt;
  const float number = parse_float(*text, find(name)->target->where, "property " + in_quotes(find(name)->name));
  const bool inside =
      range.open ? number > range.low && number < range.high : number >= range.low && number <= range.high;
  if (!inside) fail_at(name, "is " + in_quotes(*text) + ", expected " + range_text(range));
  return number;
}

float Properties::number(const char* name, float otherwise, NumberRange range) {
  return find_number(name, range).value_or(otherwise);
}

int Properties::integer(const char* name, int otherwise, int low, int high) {
  const std::string* text = value(name, {"integer"});
  if (text == nullptr) return otherwise;
  const std::int64_t number =
      parse_integer(*text, find(name)->target->where, "property " + in_quotes(find(name)->name));
  if (number < low || number > high)
    fail_at(name, "is " + in_quotes(*text) + ", expected an integer from " + std::to_string(low) + " to " +
                      std::to_string(high));
  return static_cast<int>(number);
}

bool Properties::boolean(const char* name, bool otherwise) {
  const std::string* text = value(name, {"boolean"});
  if (text == nullptr) return otherwise;
  return parse_boolean(*text, find(name)->target->where, "property " + in_quotes(find(name)->name));
}

std::optional<std::string> Properties::find_string(const char* name) {
  const std::string* text = value(name, {"string"});
  return text != nullptr ? std::optional<std::string>(*text) : std::nullopt;
}

std::optional<Vec3f> Properties::find_vec3(const char* name) {
  const Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  if (entry->target->name != "point" && entry->target->name != "vector") fail_type(*entry, "point or vector");
  return parse_vec3_element(*entry->target, 0);
}

Vec3f Properties::vec3(const char* name, Vec3f otherwise) { return find_vec3(name).value_or(otherwise); }

Transform Properties::transform(const char* name) {
  const Entry* entry = use(name);
  if (entry == nullptr) return Transform();
  if (entry->target->name != "transform") fail_type(*entry, "transform");
  return parse_transform(*entry->target);
}

std::optional<SpectrumDescription> Properties::find_spectrum(const char* name, SpectrumRole role) {
  const Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  const XmlElement& target = *entry->target;
  if (target.name == "texture")
    throw SceneError(entry->written->where, "unknown texture plugin " + in_quotes(target.attribute("type")) + " for " +
                                                in_quotes(name) + " of " + title() +
                                                ", expected a colour: rgb, srgb, spectrum or float");
  const char* const types[] = {"rgb", "srgb", "color", "spectrum", "blackbody", "float", "integer"};
  if (std::find(std::begin(types), std::end(types), target.name) == std::end(types))
    fail_type(*entry, "rgb, srgb, spectrum or float");
  SpectrumDescription result = read_spectrum(target, context_);
  if (role == SpectrumRole::kEmission && target.name == "spectrum") make_equal_energy(target, result);
  check_role(result, role, target.where, "property " + in_quotes(entry->name) + " of " + title());
  return result;
}

SpectrumDescription Properties::spectrum(const char* name, SpectrumDescription otherwise, SpectrumRole role) {
  std::optional<SpectrumDescription> found = find_spectrum(name, role);
  return found ? *std::move(found) : std::move(otherwise);
}

std::filesystem::path Properties::file(const char* name) {
  const std::optional<std::string> text = find_string(name);
  if (!text) fail("needs the string '" + std::string(name) + "'");
  return context_.scene.find_file(*text, find(name)->target->where);
}

std::vector<const XmlElement*> Properties::objects(const char* kind) {
  asked_kinds_.emplace_back(kind);
  std::vector<const XmlElement*> found;
  for (Entry& entry : entries_)
    if (entry.key.empty() && entry.target->name == kind) {
      entry.used = true;
      found.push_back(entry.target);
    }
  return found;
}

const XmlElement* Properties::object(const char* kind) {
  const std::vector<const XmlElement*> found = objects(kind);
  if (found.size() > 1) fail("holds " + std::to_string(found.size()) + " nested <" + kind + ">, expected one");
  return found.empty() ? nullptr : found[0];
}

void Properties::accept(std::initializer_list<const char*> names) {
  for (const char* name : names) use(name);
}

void Properties::finish() {
  for (const Entry& entry : entries_) {
    if (entry.used) continue;
    const SourceLocation& place = entry.written->where;
    if (entry.key.empty()) {
      std::string message = title() + " takes no nested <" + entry.target->name + ">";
      if (!asked_kinds_.empty()) message += " (it takes: " + joined(asked_kinds_) + ")";
      throw SceneError(place, message);
    }
    std::vector<std::string> keys;
    for (const std::string& name : asked_) keys.push_back(snake_case(name));
    std::string message = "unknown property " + in_quotes(entry.name) + " of " + title();
    const std::string nearest = nearest_name(entry.key, keys);
    const auto at = std::find(keys.begin(), keys.end(), nearest) - keys.begin();
    if (!nearest.empty()) message += ", did you mean '" + asked_[static_cast<std::size_t>(at)] + "'?";
    if (!context_.lenient) throw SceneError(place, message);
    context_.note(place, message + " (ignored)");
  }
}

void Properties::fail(const std::string& message) const { throw SceneError(object_.where, title() + " " + message); }

void Properties::fail_at(const char* name, const std::string& message) {
  const Entry* entry = find(name);
  if (entry == nullptr) fail("property '" + std::string(name) + "' " + message);
  throw SceneError(entry->written->where, "property " + in_quotes(entry->name) + " of " + title() + " " + message);
}

void Properties::fail_plugin(const std::vector<std::string>& known) const {
  std::string message = "unknown " + object_.name + " plugin " + in_quotes(type_) + did_you_mean(type_, known);
  throw SceneError(object_.where, message + " (known: " + (known.empty() ? "none" : joined(known)) + ")");
}

void Properties::fail_type(const Entry& entry, const char* expected) const {
  throw SceneError(entry.written->where, "property " + in_quotes(entry.name) + " of " + title() + " is given as <" +
                                             entry.target->name + ">, expected " + expected);
}

std::string Properties::title() const { return object_.name + " " + in_quotes(type_); }

}  // namespace sheaf
