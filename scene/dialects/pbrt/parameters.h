// Parameters of pbrt scene files ("type name" value) with typed access.
#pragma once

#include "scene/dialects/pbrt/tokens.h"
#include "scene/xml/named_values.h"

#include <vector>

namespace sheaf::pbrt {

struct Reader;

/// One parameter as written in the file.
struct Parameter : NamedValue {
  std::string type;
  SourceLocation where;
  std::vector<double> numbers;       ///< also booleans, as 0 and 1
  std::vector<std::string> strings;  ///< also texture names
  bool optional = false;             ///< default from the directive Attribute; may stay unused
};

/// Reads parameters up to the next directive. Throws SceneError for unknown types, values of another type and duplicate
/// parameters.
std::vector<Parameter> read_parameters(Tokens& tokens);

/// The parameters of one object. Values of the wrong type, count or range are reported and count as absent.
class Parameters : public NamedValues {
 public:
  /// `title` names the object in messages: "Shape 'sphere'". The first of several parameters with the same name counts.
  Parameters(Reader& reader, std::string title, SourceLocation where, std::vector<Parameter> list);

  Reader& reader() const { return reader_; }
  const SourceLocation& where() const { return where_; }
  std::string title() const override { return title_; }

  /// Returns the parameter of this name and marks it as used; null if absent.
  const Parameter* find(const char* name) { return static_cast<const Parameter*>(use(name)); }
  /// Returns all numbers of a parameter; their count is a multiple of `stride`. Empty if the parameter is absent.
  std::vector<float> numbers(const char* name, std::size_t stride);

  /// Reports unused parameters.
  void reject_unused();
  /// Reports that `what` is not supported, and the replacement.
  void unsupported(const std::string& what, const std::string& instead) const;

 private:
  Parameter* find_value(const char* name) override;
  const char* value_kind() const override { return "parameter"; }
  Number read_number(const NamedValue& value) const override;
  Number read_integer(const NamedValue& value) const override;
  bool read_boolean(const NamedValue& value) const override;
  std::string read_string(const NamedValue& value) const override;
  Vec3d read_vec3(const NamedValue& value) const override;
  std::filesystem::path find_file(const std::string& file, const NamedValue& value) const override;
  const SourceLocation& position_of(const NamedValue* value) const override;
  ErrorSink& errors() const override;
  /// Checks the type and the number of values of a parameter, and returns it.
  const Parameter& expect(const NamedValue& value, std::initializer_list<const char*> types, std::size_t count) const;

  Reader& reader_;
  std::string title_;
  SourceLocation where_;
  std::vector<Parameter> list_;
};

}  // namespace sheaf::pbrt
