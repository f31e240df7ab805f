# For scripts that look at installed documents; to be sourced.

dead_links() { # FOLDER: each link of a Markdown file there that leads to no file, as "file: link"
  local page link
  find "$1" -name '*.md' | sort | while read -r page; do
    sed 's/`[^`]*`//g' "$page" | grep -oP '\]\(\K[^)\s]+' | while read -r link; do
      [[ $link == *://* || $link == mailto:* || $link == \#* || -e $(dirname "$page")/${link%%#*} ]] || echo "$page: $link"
    done || true
  done
}
