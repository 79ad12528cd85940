#!/usr/bin/env python3
"""Writes a software bill of materials, SPDX 2.3 JSON, from what CMake's files say that plumbline is linked with.

    packaging/sbom.py OUT.spdx.json [--program FILE]

Components and their dependencies are read from cmake/targets.cmake and benchmarks/plumbline/CMakeLists.txt; a
dependency that the table below does not know is an error. Versions are those of the installed Debian packages.
--program: every library that the program is linked with is to be one that the bill names.
"""
import argparse
import hashlib
import json
import re
import subprocess
import sys
from datetime import datetime, timezone
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# By what CMake calls it: name, license, Debian package, shared library (none of headers alone).
KNOWN = {
    "Eigen3::Eigen": ("Eigen", "MPL-2.0", "libeigen3-dev", None),
    "opencv_core": ("OpenCV core", "Apache-2.0", "libopencv-core-dev", "libopencv_core"),
    "opencv_imgproc": ("OpenCV imgproc", "Apache-2.0", "libopencv-imgproc-dev", "libopencv_imgproc"),
    "opencv_imgcodecs": ("OpenCV imgcodecs", "Apache-2.0", "libopencv-imgcodecs-dev", "libopencv_imgcodecs"),
    "opencv_line_descriptor": ("OpenCV line_descriptor", "Apache-2.0", "libopencv-contrib-dev",
                               "libopencv_line_descriptor"),
    "JPEG::JPEG": ("libjpeg-turbo", "IJG AND BSD-3-Clause AND Zlib", "libjpeg-dev", "libjpeg"),
    "yaml-cpp": ("yaml-cpp", "MIT", "libyaml-cpp-dev", "libyaml-cpp"),
    "BZip2::BZip2": ("bzip2", "bzip2-1.0.6", "libbz2-dev", "libbz2"),
    "SQLite::SQLite3": ("SQLite", "blessing", "libsqlite3-dev", "libsqlite3"),
    "plumbline_lz4": ("LZ4", "BSD-2-Clause", "liblz4-dev", "liblz4"),
    "plumbline_zstd": ("Zstandard", "BSD-3-Clause", "libzstd-dev", "libzstd"),
    "CLI11": ("CLI11", "BSD-3-Clause", "libcli11-dev", None),
    "nlohmann_json": ("JSON for Modern C++", "MIT", "nlohmann-json3-dev", None),
    "ZLIB": ("zlib", "Zlib", "zlib1g-dev", "libz"),
    "OpenSSL": ("OpenSSL", "Apache-2.0", "libssl-dev", "libssl"),
    "PLUMBLINE_HTTP_LIBRARY": ("cpp-httplib", "MIT", "libcpp-httplib-dev", "libcpp-httplib"),
}
OF_THE_SYSTEM = {"Threads::Threads", "Threads"}
OF_THE_COMPILER = ("libstdc++", "libc++", "libm", "libgcc_s", "libc", "libpthread", "ld-linux")


def components():
    """Component -> (components, dependencies) it is linked with."""
    text = re.sub(r"#[^\n]*", "", (ROOT / "cmake/targets.cmake").read_text())
    out = {}
    for name, body in re.findall(r"plumbline_add_target\((\w+)\s([^)]*)\)", text):
        linked = re.search(r"\bLINK\s+(.*)", body, re.S).group(1).split()
        own = [x.removeprefix("plumbline_") for x in linked if re.fullmatch(r"plumbline_(core|opencv|io|bag)", x)]
        out[name] = (own, [x for x in linked if x.removeprefix("plumbline_") not in own and x not in OF_THE_SYSTEM])
    text = re.sub(r"#[^\n]*", "", (ROOT / "benchmarks/plumbline/CMakeLists.txt").read_text())
    used = re.findall(r"find_package\((\w+)", text) + re.findall(r"find_library\((PLUMBLINE_\w+)", text)
    out["program"] = (["core", "io", "opencv", "testing", "bag"], [x for x in used if x not in OF_THE_SYSTEM])
    return out


def version_of(package):
    found = subprocess.run(["dpkg-query", "-W", "-f=${Version}", package], capture_output=True, text=True)
    return found.stdout.strip() or "NOASSERTION"


def entry(spdx_id, name, version, license_id, where):
    return {"SPDXID": spdx_id, "name": name, "versionInfo": version, "supplier": "NOASSERTION",
            "downloadLocation": where, "filesAnalyzed": False, "licenseConcluded": license_id,
            "licenseDeclared": license_id, "copyrightText": "NOASSERTION"}


def spdx_id(name):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", name)


def document(parts):
    version = re.search(r"project\(plumbline VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    home = "https://github.com/plumbline/plumbline"
    packages = [entry("SPDXRef-plumbline", "plumbline", version, "Apache-2.0", f"git+{home}.git@v{version}")]
    relations = []

    def relate(a, kind, b):
        relations.append({"spdxElementId": a, "relationshipType": kind, "relatedSpdxElement": b})

    relate("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-plumbline")
    for part, (own, outside) in parts.items():
        ref = spdx_id(f"plumbline-{part}")
        packages.append(entry(ref, f"plumbline::{part}", version, "Apache-2.0", "NOASSERTION"))
        relate("SPDXRef-plumbline", "CONTAINS", ref)
        for other in own:
            relate(ref, "DEPENDS_ON", spdx_id(f"plumbline-{other}"))
        for name in outside:
            if name not in KNOWN:
                sys.exit(f"sbom.py: plumbline::{part} is linked with {name}, which the table of sbom.py does not know")
            relate(ref, "DEPENDS_ON", spdx_id(KNOWN[name][0]))
    for name in sorted({name for _, outside in parts.values() for name in outside}):
        title, license_id, debian, _ = KNOWN[name]
        package = entry(spdx_id(title), title, version_of(debian), license_id, "NOASSERTION")
        package["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                    "referenceLocator": f"pkg:deb/debian/{debian}"}]
        packages.append(package)
    content = json.dumps([packages, relations], sort_keys=True).encode()
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
            "name": f"plumbline-{version}",
            "documentNamespace": f"{home}/spdx/{version}-{hashlib.sha256(content).hexdigest()[:16]}",
            "creationInfo": {"created": datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
                             "creators": ["Tool: plumbline-sbom.py"]},
            "packages": packages, "relationships": relations}


def check_program(program, parts):
    """Of the libraries that the program is linked with, none is missing in the bill."""
    dynamic = subprocess.run(["readelf", "-d", program], capture_output=True, text=True, check=True).stdout
    linked = {re.split(r"\.so|-\d", name)[0] for name in re.findall(r"\(NEEDED\).*\[(.+)\]", dynamic)}
    own, todo = set(), ["program"]
    while todo:
        part = todo.pop()
        own.add(part)
        todo += [x for x in parts[part][0] if x not in own]
    named = {KNOWN[name][3] for part in own for name in parts[part][1]} - {None}
    missing = sorted(linked - named - set(OF_THE_COMPILER))
    if missing:
        sys.exit(f"sbom.py: {program} is linked with what the bill does not name: {', '.join(missing)}")
    print(f"{len(linked & named)} libraries of {program} are in the bill; named but not linked: "
          f"{', '.join(sorted(named - linked)) or 'none'}")


def check_document(bill):
    """Identifiers are unique and right, relationships meet them, required fields are there."""
    ids = [package["SPDXID"] for package in bill["packages"]]
    assert len(ids) == len(set(ids)) and all(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", x) for x in ids)
    for relation in bill["relationships"]:
        for key in ("spdxElementId", "relatedSpdxElement"):
            assert relation[key] in ids + ["SPDXRef-DOCUMENT"], relation
    for package in bill["packages"]:
        assert package["name"] and package["downloadLocation"] and package["versionInfo"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--program")
    options = parser.parse_args()
    parts = components()
    bill = document(parts)
    check_document(bill)
    options.out.write_text(json.dumps(bill, indent=2) + "\n")
    print(f"{options.out}: {len(bill['packages'])} packages, {len(bill['relationships'])} relationships")
    if options.program:
        check_program(options.program, parts)


if __name__ == "__main__":
    main()
