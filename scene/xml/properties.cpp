// Typed access to the properties of an object.
#include "scene/xml/properties.h"

#include "core/color/color.h"
#include "scene/xml/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

const std::vector<std::string> kPropertyTags = {"float",   "integer", "boolean", "string",   "point",     "vector",
                                                "rgb",     "srgb",    "color",   "spectrum", "blackbody", "transform",
                                                "texture", "point2",  "vector2", "animation"};
const std::vector<std::string> kObjectTags = {"sensor", "camera",     "film", "sampler",      "rfilter", "integrator",
                                              "shape",  "mesh",       "bsdf", "emitter",      "medium",  "phase",
                                              "volume", "subsurface", "test", "phasefunction"};
constexpr std::size_t kMaxNesting = 100;

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }

}  // namespace

void ReadContext::note(const SourceLocation& where, const std::string& message) {
  std::string note = SceneError(where, message).what();
  std::vector<std::string>& notes = remarks.notes;
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
}

void ReadContext::stand_in(const SourceLocation& where, const std::string& message) {
  std::string text = SceneError(where, message).what();
  std::vector<std::string>& all = remarks.stand_ins;
  if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(std::move(text));
}

bool ReadContext::leave_out(const SceneError& error, const XmlElement& around) {
  if (!lenient) throw;
  const auto* about = dynamic_cast<const ElementError*>(&error);
  if (about == nullptr || &about->element() == &around || !left_out.insert(&about->element()).second) return false;
  remarks.stand_ins.push_back(std::string(error.what()) + " (ignored)");
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
  if (context.open.size() >= kMaxNesting)
    throw SceneError(object.where, "objects are nested deeper than 100 references");
  context.open.insert(&object);
}

Properties::~Properties() { context_.open.erase(&object_); }

void Properties::expect_attributes(const XmlElement& element, std::initializer_list<const char*> allowed) const {
  try {
    element.expect_attributes(allowed);
  } catch (const SceneError& error) {
    if (!context_.lenient) throw;
    context_.stand_in({}, std::string(error.what()) + " (ignored)");
  }
}

void Properties::add(const XmlElement& child) {
  const XmlElement* target = &child;
  if (context_.left_out.count(&child) != 0) return;
  // Resolve references
  if (child.name == "ref") {
    expect_attributes(child, {"id", "name"});
    try {
      target = &context_.scene.find(child.attribute("id"), child.where);
    } catch (const SceneError& error) { throw ElementError(child, error); }
    if (context_.left_out.count(target) != 0) return;
  }
  const std::string* name = child.find_attribute("name");
  const bool nameless = name == nullptr || name->empty();
  // Add nested objects
  if (contains(kObjectTags, target->name) || (target->name == "texture" && nameless)) {
    entries_.emplace_back("", name != nullptr ? *name : "", child, *target);
    return;
  }
  if (!contains(kPropertyTags, target->name) && target->array == nullptr) {
    std::vector<std::string> known = kPropertyTags;
    known.insert(known.end(), kObjectTags.begin(), kObjectTags.end());
    known.push_back("ref");
    throw ElementError(child,
                       "unknown element <" + target->name + "> in " + title() + did_you_mean(target->name, known));
  }
  // Add properties, each once
  if (nameless) throw ElementError(child, "<" + child.name + "> in " + title() + " needs an attribute 'name'");
  const std::string key = spelling_key(*name);
  const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
  if (same != entries_.end()) {
    const std::string message = "property " + in_quotes(*name) + " is set twice, expected once";
    if (!context_.lenient) throw ElementError(child, message);
    context_.stand_in(child.where, message + " (the last one is used)");
    entries_.erase(same);
  }
  entries_.emplace_back(key, *name, child, *target);
}

Properties::Entry* Properties::look(const char* name) {
  const std::string key = spelling_key(name);
  for (Entry& entry : entries_)
    if (!entry.key.empty() && entry.key == key) return &entry;
  return nullptr;
}

const std::string& Properties::text_of(const Entry& entry, std::initializer_list<const char*> types) const {
  const bool fits = std::any_of(types.begin(), types.end(), [&](const char* t) { return entry.target->name == t; });
  if (!fits) fail_type(entry, *types.begin());
  expect_attributes(*entry.target, {"name", "id", "value"});
  if (!entry.target->children.empty())
    throw ElementError(*entry.written, "<" + entry.target->name + "> has nested elements, expected none");
  return *parsed(entry, [&] { return &entry.target->attribute("value"); });
}

bool Properties::is_texture(const char* name) {
  const Entry* entry = look(name);
  return entry != nullptr && entry->target->name == "texture";
}

const ArrayValue* Properties::find_array(const char* name) {
  const Entry* entry = look(name);
  if (entry == nullptr) return nullptr;
  if (entry->target->array == nullptr) fail_type(*entry, "an array");
  use(name);
  return entry->target->array.get();
}

std::vector<std::pair<std::string, const ArrayValue*>> Properties::arrays_with_prefix(std::string_view prefix) {
  std::vector<std::pair<std::string, const ArrayValue*>> found;
  for (Entry& entry : entries_) {
    if (entry.used || entry.target->array == nullptr || !entry.name.starts_with(prefix)) continue;
    entry.used = true;
    found.emplace_back(entry.name, entry.target->array.get());
  }
  return found;
}

bool Properties::is_string(const char* name) {
  note_query(name, "string");
  const Entry* entry = look(name);
  return entry != nullptr && entry->target->name == "string";
}

NamedValues::Number Properties::read_number(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  const std::string& text = text_of(entry, {"float", "integer"});
  const float number =
      parsed(entry, [&] { return parse_float(text, entry.target->where, "property " + in_quotes(entry.name)); });
  return {double{number}, in_quotes(text)};
}

NamedValues::Number Properties::read_integer(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  const std::string& text = text_of(entry, {"integer", "float"});
  const std::int64_t number =
      parsed(entry, [&] { return parse_integer(text, entry.target->where, "property " + in_quotes(entry.name)); });
  return {static_cast<double>(number), in_quotes(text)};
}

bool Properties::read_boolean(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  const std::string& text = text_of(entry, {"boolean"});
  return parsed(entry, [&] { return parse_boolean(text, entry.target->where, "property " + in_quotes(entry.name)); });
}

std::string Properties::read_string(const NamedValue& value) const { return text_of(entry_of(value), {"string"}); }

Vec3d Properties::read_vec3(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  if (entry.target->name != "point" && entry.target->name != "vector") fail_type(entry, "point or vector");
  return parsed(entry, [&] { return parse_vec3_element(*entry.target, 0); });
}

Vec2f Properties::vec2(const char* name, Vec2f default_value) {
  note_query(name, "two numbers or a float", default_value);
  const Entry* entry = use(name);
  if (entry == nullptr) return default_value;
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

Transform Properties::transform(const char* name) {
  note_query(name, "transform", std::string("identity"));
  const Entry* entry = use(name);
  if (entry == nullptr) return Transform();
  if (entry->target->name == "animation") {
    const std::string message = subject(*entry) + " is an <animation>, expected <transform>: it cannot move";
    if (!context_.lenient) raise(entry, message);
    context_.stand_in(entry->written->where, message + " (placed as at the first key)");
    return parsed(*entry, [&] { return parse_animation(*entry->target).reference(); });
  }
  if (entry->target->name != "transform") fail_type(*entry, "transform");
  return parsed(*entry, [&] { return parse_transform(*entry->target); });
}

Placement Properties::placement(const char* name) {
  if (!is_animation(name)) return Placement(transform(name));
  note_query(name, "transform", std::string("identity"));
  const Entry* entry = use(name);
  return parsed(*entry, [&] { return Placement(parse_animation(*entry->target)); });
}

bool Properties::is_animation(const char* name) {
  const Entry* entry = look(name);
  return entry != nullptr && entry->target->name == "animation";
}

std::optional<SpectrumDescription> Properties::find_spectrum(const char* name, SpectrumRole role) {
  note_query(name, "spectrum");
  const Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  const XmlElement& target = *entry->target;
  const char* const types[] = {"rgb", "srgb", "color", "spectrum", "blackbody", "float", "integer"};
  if (std::find(std::begin(types), std::end(types), target.name) == std::end(types))
    fail_type(*entry, "rgb, srgb, spectrum or float");
  return parsed(*entry, [&] {
    SpectrumDescription result = context_.readers.spectrum(target, role, context_);
    check_role(result, role, target.where, subject(*entry));
    return result;
  });
}

SpectrumDescription Properties::spectrum(const char* name, SpectrumDescription default_value, SpectrumRole role) {
  note_query(name, "spectrum", default_value);
  std::optional<SpectrumDescription> found = find_spectrum(name, role);
  return found ? *std::move(found) : std::move(default_value);
}

std::optional<SpectrumInput> Properties::find_spectrum_input(const char* name, SpectrumRole role) {
  note_query(name, "spectrum or texture");
  if (!is_texture(name)) return find_spectrum(name, role);
  const Entry& entry = *use(name);
  return parsed(entry, [&] {
    SpectrumInput input = context_.readers.texture(*entry.target, context_);
    if (const auto* constant = std::get_if<SpectrumDescription>(&input))
      check_role(*constant, role, entry.target->where, subject(entry));
    return input;
  });
}

SpectrumInput Properties::spectrum_input(const char* name, SpectrumInput default_value, SpectrumRole role) {
  note_query(name, "spectrum or texture", default_value);
  return find_spectrum_input(name, role).value_or(std::move(default_value));
}

std::optional<ScalarInput> Properties::find_scalar_input(const char* name, NumberRange range) {
  note_query(name, "float or texture");
  const Entry* entry = look(name);
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
    fail_at(name, "is a spectrum, expected a number or a texture");
  }
  check_range(name, {double{number}, number_text(double{number})}, range);
  return number;
}

ScalarInput Properties::scalar_input(const char* name, ScalarInput default_value, NumberRange range) {
  note_query(name, "float or texture", default_value);
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
    if (found != nullptr) throw ElementError(*entry.written, title() + " has a second colour, expected one");
    found = &entry;
  }
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

const XmlElement* Properties::any_texture() {
  note_query("texture", "texture");
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (entry.target->name != "texture" || entry.used) continue;
    if (found != nullptr) throw ElementError(*entry.written, title() + " has a second <texture>, expected one");
    found = &entry;
  }
  queried_kinds_.emplace_back("texture");
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

std::filesystem::path Properties::find_file(const std::string& file, const NamedValue& value) const {
  try {
    return context_.scene.find_file(file, entry_of(value).target->where);
  } catch (const SceneError& error) { throw ElementError(object_, error); }
}

std::vector<const XmlElement*> Properties::objects(const char* kind) {
  note_query(kind, kind);
  queried_kinds_.emplace_back(kind);
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
  if (found.size() > 1) fail("has " + std::to_string(found.size()) + " nested <" + kind + ">, expected one");
  return found.empty() ? nullptr : found[0];
}

const XmlElement* Properties::named_object(const char* kind, const char* name) {
  note_query(name, kind);
  if (!contains(queried_kinds_, kind)) queried_kinds_.emplace_back(kind);
  queried_objects_[kind].emplace_back(name);
  const std::string key = spelling_key(name);
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (!entry.key.empty() || entry.target->name != kind || spelling_key(entry.name) != key) continue;
    if (found != nullptr)
      throw ElementError(*entry.written, title() + " has a second <" + kind + "> of the name " + in_quotes(entry.name) +
                                             ", expected one");
    found = &entry;
  }
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

bool Properties::ignore_prefixed(const char* prefix) {
  note_query(prefix, "ignored");
  const std::string key = spelling_key(prefix);
  bool any = false;
  for (Entry& entry : entries_) {
    if (!entry.key.starts_with(key)) continue;
    entry.used = any = true;
  }
  return any;
}

void Properties::ignore_all() {
  if (QueryRecorder* recorder = QueryRecorder::active()) recorder->finished.insert(title());
  for (Entry& entry : entries_) entry.used = true;
}

void Properties::reject_unused() {
  for (const Entry& entry : entries_) {
    if (entry.used) continue;
    if (entry.key.empty()) fail_unused_object(entry);
    reject(entry);
  }
  if (QueryRecorder* recorder = QueryRecorder::active()) recorder->finished.insert(title());
}

void Properties::fail_unused_object(const Entry& entry) const {
  const std::string& kind = entry.target->name;
  if (kind == "texture") raise(&entry, "<" + entry.written->name + "> in " + title() + " needs an attribute 'name'");
  std::string message = title() + " takes no nested <" + kind + ">";
  if (const auto known = queried_objects_.find(kind); known != queried_objects_.end()) {
    message += entry.name.empty() ? " without a name" : " of the name " + in_quotes(entry.name);
    message += did_you_mean(spelling_key(entry.name), known->second);
    raise(&entry, message + known_names(known->second));
  }
  if (!queried_kinds_.empty()) message += " (known: " + joined(queried_kinds_) + ")";
  raise(&entry, message);
}

void Properties::throw_error(const NamedValue* value, const std::string& message) const {
  throw ElementError(value != nullptr ? *entry_of(*value).written : object_, message);
}

void Properties::leave_out(const NamedValue& value, const std::string& message) const {
  if (!context_.lenient) raise(&value, message);
  context_.stand_in(entry_of(value).written->where, message + " (ignored)");
}

void Properties::fail_plugin(std::vector<std::string> known) const {
  std::sort(known.begin(), known.end());
  if (QueryRecorder* recorder = QueryRecorder::active())
    recorder->plugins[object_.name].insert(known.begin(), known.end());
  throw ElementError(object_, "unknown " + object_.name + " plugin " + in_quotes(type_) + did_you_mean(type_, known) +
                                  known_names(known));
}

void Properties::fail_type(const Entry& entry, const char* expected) const {
  fail_value(entry, "is given as <" + entry.target->name + ">, expected " + expected);
}

std::string Properties::title() const { return object_.name + " " + in_quotes(type_); }

}  // namespace sheaf
