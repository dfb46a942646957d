// text_of: converts texts of the libraries to texts of Qt.
#pragma once

#include <QString>
#include <string>

namespace trephine::view {

inline QString text_of(const std::string& text) { return QString::fromStdString(text); }
/// Returns a text for a label with word wrap, in which "X-ray" is not broken.
inline QString wrapping(QString text) { return text.replace("X-ray", QString("X%1ray").arg(QChar(0x2011))); }

}  // namespace trephine::view
