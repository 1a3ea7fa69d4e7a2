// Typed access to the properties of an object.
#include "scene/xml/properties.h"

#include "core/color.h"
#include "scene/xml/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

const std::vector<std::string> kPropertyTags = {"float",     "integer",   "boolean", "string", "point",
                                                "vector",    "rgb",       "srgb",    "color",  "spectrum",
                                                "blackbody", "transform", "texture", "point2", "vector2"};
const std::vector<std::string> kObjectTags = {"sensor", "camera",     "film", "sampler",      "rfilter", "integrator",
                                              "shape",  "mesh",       "bsdf", "emitter",      "medium",  "phase",
                                              "volume", "subsurface", "test", "phasefunction"};
constexpr std::size_t kMaxNesting = 100;

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }

bool is_inside(double number, NumberRange range) {
  return range.open ? number > range.low && number < range.high : number >= range.low && number <= range.high;
}

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

}  // namespace

void ReadContext::note(const SourceLocation& where, const std::string& message) {
  std::string note = SceneError(where, message).what();
  std::vector<std::string>& notes = description.notes;
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
}

void ReadContext::stand_in(const SourceLocation& where, const std::string& message) {
  std::string text = SceneError(where, message).what();
  std::vector<std::string>& all = description.stand_ins;
  if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(std::move(text));
}

bool ReadContext::leave_out(const SceneError& error, const XmlElement& around) {
  if (!lenient) throw;
  const auto* about = dynamic_cast<const ElementError*>(&error);
  if (about == nullptr || &about->element() == &around || !left_out.insert(&about->element()).second) return false;
  description.stand_ins.push_back(std::string(error.what()) + " (left out)");
  return true;
}

std::string spelling_key(std::string_view name) {
  std::string key;
  for (const char c : name)
    if (c != '_') key += is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
  return key;
}

Properties::Properties(const XmlElement& object, ReadContext& context) : object_(object), context_(context) {
  expect_attributes(object, {"type", "id", "name", "version"});
  if (object.find_attribute("type") == nullptr)
    throw ElementError(object, "<" + object.name + "> needs an attribute 'type'");
  const auto other = context.types.find(&object);
  type_ = other != context.types.end() ? other->second : object.attribute("type");
  for (const XmlElement& child : object.children) add(child);
  if (context.open.count(&object) != 0) throw ElementError(object, title() + " refers to itself");
  if (context.open.size() >= kMaxNesting) throw SceneError(object.where, "objects refer to each other too deeply");
  context.open.insert(&object);
}

Properties::~Properties() { context_.open.erase(&object_); }

void Properties::expect_attributes(const XmlElement& element, std::initializer_list<const char*> allowed) const {
  try {
    element.expect_attributes(allowed);
  } catch (const SceneError& error) {
    if (!context_.lenient) throw;
    context_.stand_in({}, std::string(error.what()) + " (left out)");
  }
}

void Properties::add(const XmlElement& child) {
  const XmlElement* target = &child;
  if (context_.left_out.count(&child) != 0) return;
  if (child.name == "ref") {
    expect_attributes(child, {"id", "name"});
    try {
      target = &context_.scene.find(child.attribute("id"), child.where);
    } catch (const SceneError& error) { throw ElementError(child, error); }
    if (context_.left_out.count(target) != 0) return;
  }
  const std::string* name = child.find_attribute("name");
  const bool nameless = name == nullptr || name->empty();
  if (contains(kObjectTags, target->name) || (target->name == "texture" && nameless)) {
    entries_.push_back({"", name != nullptr ? *name : "", &child, target});
    return;
  }
  if (!contains(kPropertyTags, target->name)) {
    std::vector<std::string> known = kPropertyTags;
    known.insert(known.end(), kObjectTags.begin(), kObjectTags.end());
    known.push_back("ref");
    throw ElementError(child,
                       "unknown element <" + target->name + "> in " + title() + did_you_mean(target->name, known));
  }
  if (nameless) throw ElementError(child, "<" + child.name + "> in " + title() + " needs an attribute 'name'");
  const std::string key = spelling_key(*name);
  const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
  if (same != entries_.end()) {
    const std::string message = "property " + in_quotes(*name) + " is given twice";
    if (!context_.lenient) throw ElementError(child, message);
    context_.stand_in(child.where, message + " (the last counts)");
    entries_.erase(same);
  }
  entries_.push_back({key, *name, &child, target});
}

Properties::Entry* Properties::find(const char* name) {
  const std::string key = spelling_key(name);
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
  expect_attributes(*entry->target, {"name", "id", "value"});
  if (!entry->target->children.empty())
    throw ElementError(*entry->written, "<" + entry->target->name + "> holds no elements");
  return parsed(*entry, [&] { return &entry->target->attribute("value"); });
}

bool Properties::has(const char* name) {
  asked_.emplace_back(name);
  return find(name) != nullptr;
}

bool Properties::is_texture(const char* name) {
  const Entry* entry = find(name);
  return entry != nullptr && entry->target->name == "texture";
}

bool Properties::is_string(const char* name) {
  const Entry* entry = find(name);
  return entry != nullptr && entry->target->name == "string";
}

std::optional<float> Properties::find_number(const char* name, NumberRange range) {
  const std::string* text = value(name, {"float", "integer"});
  if (text == nullptr) return std::nullopt;
  const Entry& entry = *find(name);
  const float number =
      parsed(entry, [&] { return parse_float(*text, entry.target->where, "property " + in_quotes(entry.name)); });
  if (!is_inside(number, range)) fail_at(name, "is " + in_quotes(*text) + ", expected " + range_text(range));
  return number;
}

float Properties::number(const char* name, float default_value, NumberRange range) {
  return find_number(name, range).value_or(default_value);
}

int Properties::integer(const char* name, int default_value, int low, int high) {
  const std::string* text = value(name, {"integer", "float"});
  if (text == nullptr) return default_value;
  const Entry& entry = *find(name);
  const std::int64_t number =
      parsed(entry, [&] { return parse_integer(*text, entry.target->where, "property " + in_quotes(entry.name)); });
  if (number < low || number > high)
    fail_at(name, "is " + in_quotes(*text) + ", expected an integer from " + std::to_string(low) + " to " +
                      std::to_string(high));
  return static_cast<int>(number);
}

bool Properties::boolean(const char* name, bool default_value) {
  const std::string* text = value(name, {"boolean"});
  if (text == nullptr) return default_value;
  const Entry& entry = *find(name);
  return parsed(entry, [&] { return parse_boolean(*text, entry.target->where, "property " + in_quotes(entry.name)); });
}

std::optional<std::string> Properties::find_string(const char* name) {
  const std::string* text = value(name, {"string"});
  return text != nullptr ? std::optional<std::string>(*text) : std::nullopt;
}

std::optional<Vec3f> Properties::find_vec3(const char* name) {
  const Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  if (entry->target->name != "point" && entry->target->name != "vector") fail_type(*entry, "point or vector");
  return parsed(*entry, [&] { return parse_vec3_element(*entry->target, 0); });
}

std::optional<Vec2f> Properties::find_vec2(const char* name) {
  const Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  const XmlElement& target = *entry->target;
  if (target.name == "float" || target.name == "integer") {
    const float number = *find_number(name);
    return Vec2f{number, number};
  }
  const char* const types[] = {"vector2", "point2", "vector", "point"};
  if (std::find(std::begin(types), std::end(types), target.name) == std::end(types))
    fail_type(*entry, "vector2 or float");
  expect_attributes(target, {"name", "id", "value"});
  const std::vector<float> v = parsed(*entry, [&] {
    return parse_floats(target.attribute("value"), target.where, "property " + in_quotes(entry->name));
  });
  if (v.size() != 2) fail_at(name, "has " + std::to_string(v.size()) + " numbers, expected two");
  return Vec2f{v[0], v[1]};
}

Vec3f Properties::vec3(const char* name, Vec3f default_value) { return find_vec3(name).value_or(default_value); }

Transform Properties::transform(const char* name) {
  const Entry* entry = use(name);
  if (entry == nullptr) return Transform();
  if (entry->target->name != "transform") fail_type(*entry, "transform");
  return parsed(*entry, [&] { return parse_transform(*entry->target); });
}

std::optional<SpectrumDescription> Properties::find_spectrum(const char* name, SpectrumRole role) {
  const Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  const XmlElement& target = *entry->target;
  const char* const types[] = {"rgb", "srgb", "color", "spectrum", "blackbody", "float", "integer"};
  if (std::find(std::begin(types), std::end(types), target.name) == std::end(types))
    fail_type(*entry, "rgb, srgb, spectrum or float");
  return parsed(*entry, [&] {
    SpectrumDescription result = context_.readers.spectrum(target, role, context_);
    check_role(result, role, target.where, "property " + in_quotes(entry->name) + " of " + title());
    return result;
  });
}

SpectrumDescription Properties::spectrum(const char* name, SpectrumDescription default_value, SpectrumRole role) {
  std::optional<SpectrumDescription> found = find_spectrum(name, role);
  return found ? *std::move(found) : std::move(default_value);
}

std::optional<SpectrumInput> Properties::find_spectrum_input(const char* name, SpectrumRole role) {
  if (!is_texture(name)) return find_spectrum(name, role);
  const Entry& entry = *use(name);
  return parsed(entry, [&] {
    SpectrumInput input = context_.readers.texture(*entry.target, context_);
    if (const auto* constant = std::get_if<SpectrumDescription>(&input))
      check_role(*constant, role, entry.target->where, "property " + in_quotes(entry.name) + " of " + title());
    return input;
  });
}

SpectrumInput Properties::spectrum_input(const char* name, SpectrumInput default_value, SpectrumRole role) {
  return find_spectrum_input(name, role).value_or(std::move(default_value));
}

std::optional<ScalarInput> Properties::find_scalar_input(const char* name, NumberRange range) {
  const Entry* entry = find(name);
  if (entry == nullptr || entry->target->name == "float" || entry->target->name == "integer")
    return find_number(name, range);
  const char* const types[] = {"texture", "spectrum", "rgb", "srgb", "color"};
  if (std::find(std::begin(types), std::end(types), entry->target->name) == std::end(types))
    fail_type(*use(name), "float or texture");
  const std::optional<SpectrumInput> input = find_spectrum_input(name, SpectrumRole::kIor);
  if (const auto* texture = std::get_if<TextureId>(&*input)) return context_.readers.scalar_texture(*texture, context_);
  const SpectrumDescription& spectrum = std::get<SpectrumDescription>(*input);
  float number = 0;
  if (const auto* constant = std::get_if<SpectrumDescription::Constant>(&spectrum.value)) {
    number = constant->value;
  } else if (const auto* rgb = std::get_if<SpectrumDescription::Rgb>(&spectrum.value)) {
    number = luminance(rgb->value);
  } else {
    fail_at(name, "depends on the wavelength, expected a number or a texture");
  }
  if (!is_inside(number, range)) fail_at(name, "is " + std::to_string(number) + ", expected " + range_text(range));
  return number;
}

ScalarInput Properties::scalar_input(const char* name, ScalarInput default_value, NumberRange range) {
  return find_scalar_input(name, range).value_or(default_value);
}

const char* Properties::first_color() const {
  const std::vector<std::string> kinds = {"rgb", "srgb", "color", "spectrum", "texture"};
  for (const Entry& entry : entries_)
    if (!entry.key.empty() && contains(kinds, entry.target->name)) return entry.name.c_str();
  return nullptr;
}

const XmlElement* Properties::any_texture_or_color() {
  if (const XmlElement* texture = any_texture()) return texture;
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    const std::string& kind = entry.target->name;
    if (entry.used || (kind != "rgb" && kind != "srgb" && kind != "color" && kind != "spectrum")) continue;
    if (found != nullptr) throw ElementError(*entry.written, title() + " holds a second colour, expected one");
    found = &entry;
  }
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

const XmlElement* Properties::any_texture() {
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (entry.target->name != "texture" || entry.used) continue;
    if (found != nullptr) throw ElementError(*entry.written, title() + " holds a second <texture>, expected one");
    found = &entry;
  }
  asked_kinds_.emplace_back("texture");
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

std::filesystem::path Properties::file(const char* name) {
  const std::optional<std::string> text = find_string(name);
  if (!text) fail("needs the string '" + std::string(name) + "'");
  try {
    return context_.scene.find_file(*text, find(name)->target->where);
  } catch (const SceneError& error) { throw ElementError(object_, error); }
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

const XmlElement* Properties::named_object(const char* kind, const char* name) {
  if (!contains(asked_kinds_, kind)) asked_kinds_.emplace_back(kind);
  asked_objects_[kind].emplace_back(name);
  const std::string key = spelling_key(name);
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (!entry.key.empty() || entry.target->name != kind || spelling_key(entry.name) != key) continue;
    if (found != nullptr)
      throw ElementError(*entry.written, title() + " holds a second <" + kind + "> of the name " +
                                             in_quotes(entry.name) + ", expected one");
    found = &entry;
  }
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

void Properties::ignore(std::initializer_list<const char*> names) {
  for (const char* name : names) use(name);
}

bool Properties::ignore_prefixed(const char* prefix) {
  const std::string key = spelling_key(prefix);
  bool any = false;
  for (Entry& entry : entries_) {
    if (!entry.key.starts_with(key)) continue;
    entry.used = any = true;
  }
  return any;
}

void Properties::ignore_all() {
  for (Entry& entry : entries_) entry.used = true;
}

void Properties::reject_unused() {
  for (const Entry& entry : entries_) {
    if (entry.used) continue;
    const XmlElement& place = *entry.written;
    if (entry.key.empty()) {
      if (entry.target->name == "texture")
        throw ElementError(place, "<" + entry.written->name + "> in " + title() + " needs an attribute 'name'");
      std::string message = title() + " takes no nested <" + entry.target->name + ">";
      if (const auto known = asked_objects_.find(entry.target->name); known != asked_objects_.end()) {
        message += entry.name.empty() ? " without a name" : " of the name " + in_quotes(entry.name);
        message += did_you_mean(spelling_key(entry.name), known->second);
        throw ElementError(place, message + known_names(known->second));
      }
      if (!asked_kinds_.empty()) message += " (it takes: " + joined(asked_kinds_) + ")";
      throw ElementError(place, message);
    }
    std::vector<std::string> keys;
    for (const std::string& name : asked_) keys.push_back(spelling_key(name));
    std::string message = "unknown property " + in_quotes(entry.name) + " of " + title();
    const std::string nearest = nearest_name(entry.key, keys);
    const auto at = std::find(keys.begin(), keys.end(), nearest) - keys.begin();
    if (!nearest.empty()) message += ", did you mean '" + asked_[static_cast<std::size_t>(at)] + "'?";
    if (!context_.lenient) throw ElementError(place, message);
    context_.stand_in(place.where, message + " (left out)");
  }
}

void Properties::fail(const std::string& message) const { throw ElementError(object_, title() + " " + message); }

void Properties::fail_at(const char* name, const std::string& message) {
  const Entry* entry = find(name);
  if (entry == nullptr) fail("property '" + std::string(name) + "' " + message);
  throw ElementError(*entry->written, "property " + in_quotes(entry->name) + " of " + title() + " " + message);
}

void Properties::fail_choice(const char* name, std::string_view text, const std::vector<std::string>& known) {
  fail_at(name, "is " + in_quotes(text) + ", expected " + one_of(known) + did_you_mean(text, known));
}

void Properties::fail_plugin(std::vector<std::string> known) const {
  std::sort(known.begin(), known.end());
  throw ElementError(object_, "unknown " + object_.name + " plugin " + in_quotes(type_) + did_you_mean(type_, known) +
                                  known_names(known));
}

void Properties::fail_type(const Entry& entry, const char* expected) const {
  throw ElementError(*entry.written, "property " + in_quotes(entry.name) + " of " + title() + " is given as <" +
                                         entry.target->name + ">, expected " + expected);
}

std::string Properties::title() const { return object_.name + " " + in_quotes(type_); }

}  // namespace sheaf
