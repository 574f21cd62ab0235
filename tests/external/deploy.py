#!/usr/bin/env python3
"""The files that deploy a farm: what their schemas say, and what every container must have.

    python3 tests/external/deploy.py

Schemas of Compose and of Kubernetes come from the package index. Overlays are built by kubectl or kustomize, if there is one.
"""

import json
import pathlib
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True  # leaves nothing beside this file
import service  # noqa: E402

DEPLOY = service.ROOT / "deploy"
PACKAGES = ["check-jsonschema==0.39.0", "kubernetes-validate==1.37.0", "PyYAML==6.0.3"]
# Prints the documents of YAML files as JSON: this program runs without packages.
AS_JSON = "import json, sys, yaml; print(json.dumps([each for name in sys.argv[1:] for each in yaml.safe_load_all(open(name)) if each]))"


def documents(programs, *files):
    made = subprocess.run([programs / "python", "-c", AS_JSON, *files], capture_output=True, text=True, check=True)
    return json.loads(made.stdout)


def run(*command):
    made = subprocess.run(command, capture_output=True, text=True)
    if made.returncode:
        sys.exit(f"{' '.join(map(str, command))}:\n{made.stdout}{made.stderr}")
    return made.stdout


def check_containers(where, objects):
    """Each container is locked, has its limits, and is not root."""
    count = 0
    for each in objects:
        if each["kind"] not in ("Deployment", "StatefulSet", "Job", "DaemonSet"):
            continue
        pod = each["spec"]["template"]["spec"]
        name = f"{where}: {each['metadata']['name']}"
        assert pod["securityContext"]["runAsNonRoot"], name
        assert pod["securityContext"]["seccompProfile"]["type"] == "RuntimeDefault", name
        assert pod["automountServiceAccountToken"] is False, name
        assert pod["terminationGracePeriodSeconds"] > 30, name
        for container in pod["containers"]:
            locked = container["securityContext"]
            assert locked["readOnlyRootFilesystem"] and not locked["allowPrivilegeEscalation"], name
            assert locked["capabilities"]["drop"] == ["ALL"], name
            assert container["resources"]["limits"]["memory"] and container["resources"]["requests"]["cpu"], name
            count += 1
    assert count >= 2, where


def check_budgets(where, objects):
    """Each deployment has a disruption budget for its pods."""
    budgets = [each["spec"]["selector"]["matchLabels"] for each in objects if each["kind"] == "PodDisruptionBudget"]
    for each in objects:
        if each["kind"] == "Deployment":
            assert each["spec"]["selector"]["matchLabels"] in budgets, f"{where}: {each['metadata']['name']} has no budget"


def main():
    programs = service.python(*PACKAGES)
    compose = sorted(DEPLOY.glob("compose*.yaml"))
    run(programs / "check-jsonschema", "--builtin-schema", "vendor.compose-spec", *compose)
    for file in compose:
        for name, each in documents(programs, file)[0]["services"].items():
            # A file that only changes services of another says no image.
            if "image" in each:
                assert each["read_only"] and each["cap_drop"] == ["ALL"] and each["security_opt"], f"{file.name}: {name}"
    print(f"{len(compose)} compose files")
    kubernetes = DEPLOY / "kubernetes"
    files = [each for each in sorted(kubernetes.rglob("*.yaml")) if each.name not in ("kustomization.yaml", "values.yaml", "nodes-by-backlog.yaml")]
    run(programs / "kubernetes-validate", "--strict", "--quiet", *files)
    objects = documents(programs, *files)
    check_containers("base", objects)
    check_budgets("base", objects)
    documents(programs, *kubernetes.rglob("*.yaml"))
    print(f"{len(objects)} objects in {len(files)} files")
    builder = [shutil.which("kubectl"), "kustomize"] if shutil.which("kubectl") else [shutil.which("kustomize"), "build"]
    if not builder[0]:
        print("left out: overlays (there is neither kubectl nor kustomize)")
        return
    for overlay in sorted((kubernetes / "overlays").iterdir()):
        built = service.TOOLS / f"{overlay.name}.yaml"
        built.write_text(run(*builder, overlay))
        objects = documents(programs, built)
        check_containers(overlay.name, objects)
        check_budgets(overlay.name, objects)
        assert all(each["metadata"].get("namespace") == "strahl" for each in objects if each["kind"] not in ("Namespace", "PriorityClass"))
        # KEDA's kind is not one of Kubernetes.
        known = service.TOOLS / f"{overlay.name}.json"
        known.write_text("\n---\n".join(json.dumps(each) for each in objects if each["kind"] != "ScaledObject"))
        run(programs / "kubernetes-validate", "--strict", "--quiet", known)
        print(f"overlay {overlay.name}: {len(objects)} objects")


if __name__ == "__main__":
    main()
