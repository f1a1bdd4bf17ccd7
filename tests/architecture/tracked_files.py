"""The files that the architecture tests look at: what git tracks or would add, or, in a copy without git, what is there."""
import pathlib
import subprocess

NOT_OURS = {"build", "data", "node_modules", "vendor", ".git", "__pycache__"}


def tracked_files(root, *folders):
    """Paths below `root` as text with slashes, in order; below `folders` alone where any are named."""
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard", *folders],
                            capture_output=True, text=True)
    if listed.returncode == 0:
        names = [name for name in listed.stdout.splitlines() if (root / name).is_file()]
    else:
        names = [path.relative_to(root).as_posix() for folder in folders or ["."] for path in (root / folder).rglob("*")
                 if path.is_file() and not NOT_OURS & set(path.relative_to(root).parts)]
    assert names, f"there are no files below {root}"
    return sorted(names)
