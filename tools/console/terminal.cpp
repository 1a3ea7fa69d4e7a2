#include "tools/console/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace sheaf {

int terminal_columns(int descriptor) {
  winsize size{};
  return ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

int text_columns() {
  constexpr int kMin = 40, kMax = 120, kDefault = 80;
  int columns = terminal_columns(STDOUT_FILENO);
  if (const char* const given = std::getenv("COLUMNS"); columns == 0 && given != nullptr) columns = std::atoi(given);
  return columns <= 0 ? kDefault : std::clamp(columns, kMin, kMax);
}

}  // namespace sheaf
