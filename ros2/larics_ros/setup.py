from glob import glob

from setuptools import setup

NAME = "larics_ros"

setup(
    name=NAME,
    version="1.0.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        ("share/" + NAME + "/launch", glob("launch/*.launch.py")),
        ("share/" + NAME + "/config", glob("config/*")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="The LARICS camera's maintainers",
    maintainer_email="larics@example.org",
    description="Launches the LARICS camera: pose on a map of ceiling markers, transforms, diagnostics",
    license="MIT",
)
