#!/usr/bin/env python3
"""The files that deploy a farm: what their schemas say, what every container must have, and that what they start starts.

    python3 tests/external/deploy.py

Schemas of Compose and of Kubernetes come from the package index. Overlays are built by kubectl or kustomize, if there is one.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # leaves nothing beside this file
import service  # noqa: E402
from broker import Broker  # noqa: E402

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


def of_image():
    """The environment of the image."""
    return dict(re.findall(r"^ENV (\w+)=(\S+)$", (service.ROOT / "Dockerfile").read_text(), re.MULTILINE))


def of_compose(programs, file):
    """Arguments and environment of the program in each service of a compose file, as fronts and as nodes."""
    for name, each in documents(programs, file)[0]["services"].items():
        if each.get("image", "").startswith("strahl:") and each["command"][0] in ("serve", "node"):
            yield f"{file.name}: {name}", each["command"], each["environment"]


def of_kubernetes(programs, base):
    """The same of each container."""
    shared = documents(programs, base / "kustomization.yaml")[0]["configMapGenerator"]
    shared = dict(line.split("=", 1) for made in shared if made["name"] == "strahl-farm" for line in made["literals"])
    for each in documents(programs, *sorted(base.glob("*.yaml"))):
        if each["kind"] in ("Deployment", "StatefulSet"):
            for container in each["spec"]["template"]["spec"]["containers"]:
                if container["image"] == "strahl":
                    own = {one["name"]: one["value"] for one in container["env"] if "value" in one}
                    yield f"kubernetes: {container['name']}", container["args"], {**shared, **own}


def check_starts(name, arguments, environment, broker, folder):
    """The program starts and ends as a container does, with a broker and a store of this machine, and without secrets."""
    environment = {**of_image(), **environment, "STRAHL_FARM": f"nats://127.0.0.1:{broker.port}", "STRAHL_STORE": str(folder / "store")}
    secrets = ("STRAHL_FARM_CREDENTIALS", "STRAHL_FARM_INBOX", "STRAHL_FARM_CA")
    local = [(r"^/data", str(folder / "data")), (r"^/run/strahl/keys.toml$", str(folder / "keys.toml")), (r"^[\d.]+:(8080|9090)$", "127.0.0.1:0")]

    def here(value):
        for pattern, by in local:
            value = re.sub(pattern, by, str(value))
        return value

    environment = {key: here(value) for key, value in environment.items() if key not in secrets}
    log = folder / "log"
    with open(log, "w") as sink:
        process = subprocess.Popen([service.PROGRAM, *map(here, arguments)], env=environment, stderr=sink)
    # A front says where it listens; a node that cannot work ends.
    is_front = arguments[0] == "serve"
    until = time.monotonic() + (30 if is_front else 3)
    while process.poll() is None and time.monotonic() < until and not (is_front and "listening on" in log.read_text()):
        time.sleep(0.1)
    process.terminate()
    code = process.wait(timeout=60)
    said = log.read_text()
    assert code == 0 and (not is_front or "listening on" in said), f"{name}: {code}\n{said}"


def check_programs(programs):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        service.key(folder / "keys.toml", "one")
        broker = Broker(folder).until_healthy()
        try:
            started = [*of_compose(programs, DEPLOY / "compose.yaml"), *of_kubernetes(programs, DEPLOY / "kubernetes/base")]
            for name, arguments, environment in started:
                check_starts(name, arguments, environment, broker, folder)
        finally:
            broker.stop()
    assert len(started) == 4, started
    print(f"{len(started)} programs start and end")


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
    check_programs(programs)
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
