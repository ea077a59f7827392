// The page's parts, compiled in from page.html, page.css, page.js and icon.svg.
#pragma once

#include <string_view>

namespace cheval::hal {

extern const std::string_view kPageHtml;
extern const std::string_view kPageStyle;
extern const std::string_view kPageScript;
extern const std::string_view kPageIcon;

}  // namespace cheval::hal
