# Puts style and script into the page, and the page into a C++ source: cmake -D PAGE= -D STYLE= -D SCRIPT= -D OUT= -P embed.cmake
file(READ "${PAGE}" page)
file(READ "${STYLE}" style)
file(READ "${SCRIPT}" script)
# What would end the elements they stand in.
string(REPLACE "</script" "<\\/script" script "${script}")
string(REPLACE "@DIESINK_STYLE@" "${style}" page "${page}")
string(REPLACE "@DIESINK_SCRIPT@" "${script}" page "${page}")
set(text "// Written by viewer/embed.cmake.\n#include \"viewer/page.h\"\nnamespace diesink {\n")
string(APPEND text "std::optional<std::string_view> viewer_page() {\n  static constexpr char kPage[] = R\"diesink(")
string(APPEND text "${page}")
string(APPEND text ")diesink\";\n  return std::string_view(kPage, sizeof kPage - 1);\n}\n}  // namespace diesink\n")
file(WRITE "${OUT}" "${text}")
