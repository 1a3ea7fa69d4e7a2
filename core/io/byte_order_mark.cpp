// Detection of the byte order marks of UTF-8, UTF-16 and UTF-32.
#include "core/io/byte_order_mark.h"

#include <string_view>

namespace sheaf {

void remove_byte_order_mark(std::string& text, const std::string& file) {
  using namespace std::string_view_literals;
  if (text.starts_with("\xef\xbb\xbf"sv)) text.erase(0, 3);
  const bool wide = text.starts_with("\xff\xfe\0\0"sv) || text.starts_with("\0\0\xfe\xff"sv);
  if (wide || text.starts_with("\xff\xfe"sv) || text.starts_with("\xfe\xff"sv))
    throw SceneError({file, 1}, fmt::format("the file is text in {} (expected UTF-8: save it in that encoding)",
                                            wide ? "UTF-32" : "UTF-16"));
}

}  // namespace sheaf
