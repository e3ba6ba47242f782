def write(axes, cases, directory):
    pass
