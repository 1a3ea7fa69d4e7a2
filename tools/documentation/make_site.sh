#!/usr/bin/env bash
# Builds the documentation site in out/site on Debian 12 or 13. Installs MkDocs and its theme Material if they are
# missing. Needs a build: the pages of the command line come from `sheaf --help`. Set SHEAF if it is not
# build/release/sheaf.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

export SHEAF=${SHEAF:-build/release/sheaf}
if [[ ! -x $SHEAF ]]; then
  echo "site: no $SHEAF: run tools/quickstart.sh, or set SHEAF to the executable" >&2
  exit 1
fi
tools/install_packages.sh git python3 mkdocs mkdocs-material python3-pygments
rm -rf out/site
# The package installs this script for Debian's Python; another one in PATH may lack the theme.
/usr/bin/mkdocs build --strict --quiet
tests/docs/check_links.py --site out/site
echo "site: out/site/index.html"
