// text_of: texts of the libraries for Qt.
#pragma once

#include <QString>
#include <string>

namespace trephine::view {

inline QString text_of(const std::string& text) { return QString::fromStdString(text); }

}  // namespace trephine::view
